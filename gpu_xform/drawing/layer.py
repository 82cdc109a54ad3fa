"""Layers: a model of a picture, where it stands, and how it is drawn."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import Any, TypeAlias, TypedDict, TypeGuard

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_real_array, as_square_matrices
from .._core.error_context import prefix_errors
from .._core.public import public
from .._core.types import Float64Array, MatrixLike, StrPath
from ..compute._arrays import as_host_array
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.edges import EdgesLike, angle
from ..geometry.mesh import Mesh
from ..geometry.scene import Instances, Scene
from ..imaging.colors import ColorLike
from .enums import HIDDEN_STYLES, HiddenStyle

Model: TypeAlias = Mesh | npt.NDArray[Any] | PointBuffer | StrPath

_MODEL_TYPES = (Mesh, PointBuffer, str, os.PathLike)
MAX_LINE_WIDTH_PX = 1e6  # pixels; beyond that single precision loses the line's rim


class Style(TypedDict, total=False):
    """The keywords that say how a model is drawn: those of `Layer`."""

    transform: MatrixLike | None
    name: str | None
    edges: EdgesLike | None
    feature_angle: float
    hidden: HiddenStyle | None
    line_width: float
    antialias: bool
    color: ColorLike
    face_colors: npt.ArrayLike | None
    edge_colors: npt.ArrayLike | None
    vertex_colors: npt.ArrayLike | None
    scalars: npt.ArrayLike | None
    cmap: Any
    clim: Sequence[float] | None
    alpha: float
    depth_cue: float
    fill: Any
    point_size: float | None


@public
@dataclass(frozen=True, eq=False)
class Layer:
    """A model of a picture, where it stands, and how it is drawn.

    model : a Mesh, an array of points (n, 3), of which a Mesh is made, the path of a model file, or a PointBuffer
        (n, 3), which is drawn where it is
    transform : (4, 4), from the model to the world, or (k, 4, 4) for k instances; the identity by default
    name : of the model in vector pictures; a file's own by default
    edges : which to draw: "all", "feature" (creases and rims), "boundary" (rims), "silhouette" (what is seen edge-on,
        and rims), (m, 2) indices of points, or several of these; by default all, in a PointBuffer none but those given
    feature_angle : degrees by which two faces must turn at a crease
    hidden : what is done with edges behind faces, of this model or another: "show", "remove", "dash" or "fade"; "show"
        by default, "remove" where `fill` is given. The faces of a layer hide others unless it shows all its edges.
    line_width : pixels, positive and at most 1e6
    antialias : False draws lines one pixel wide, each pixel on or off: fast, and whatever line_width says
    color : a name, "#rrggbb", or numbers from 0 to 1; "face" draws the outline of each face in its own colour, from a
        cycle of ten; an edge that faces share has that of the last
    face_colors : (f, 3 or 4), in place of the cycle
    edge_colors : (m, 3 or 4), one for each row of `Mesh.edges`, or of `edges` where that is an array
    vertex_colors : (n, 3 or 4), blended along the edges
    scalars : (n,), one a point, shown as `cmap` has it between the two limits `clim`, by default their own
    alpha : opacity of all that is drawn, from 0 to 1
    depth_cue : what the farthest point of the picture loses of its opacity, from 0 to 1; in between it goes by distance
    fill : a colour that the faces are painted in, "face" for the cycle of ten, or (f, 3 or 4)
    point_size : diameter in pixels of a dot at each point; none by default, 2 for models that have points alone

    Of colours, one of face_colors, edge_colors, vertex_colors and scalars may be given. Of a layer's lines, and of its
    dots, nearer ones lie over farther ones.
    """

    model: Model
    _: KW_ONLY
    transform: MatrixLike | None = None
    name: str | None = None
    edges: EdgesLike | None = None
    feature_angle: float = 30.0
    hidden: HiddenStyle | None = None
    line_width: float = 1.5
    antialias: bool = True
    color: ColorLike = "black"
    face_colors: npt.ArrayLike | None = None
    edge_colors: npt.ArrayLike | None = None
    vertex_colors: npt.ArrayLike | None = None
    scalars: npt.ArrayLike | None = None
    cmap: Any = "viridis"
    clim: Sequence[float] | None = None
    alpha: float = 1.0
    depth_cue: float = 0.0
    fill: Any = None
    point_size: float | None = None

    def __post_init__(self) -> None:
        if is_point_array(self.model):
            object.__setattr__(self, "model", mesh_from_points(self.model))
        if not isinstance(self.model, _MODEL_TYPES):
            raise ArgumentTypeError.expecting(
                "model", "be a Mesh, an array of points, a PointBuffer or a path", type(self.model).__name__
            )
        if not isinstance(self.name, str | None):
            raise ArgumentTypeError.expecting("name", "be a string", repr(self.name))
        hidden: object = self.hidden
        if not (hidden is None or (isinstance(hidden, str) and hidden in HIDDEN_STYLES)):
            names = ", ".join(map(repr, HIDDEN_STYLES))
            raise ArgumentError.expecting("hidden", f"be one of {names}", repr(self.hidden))
        if not isinstance(self.antialias, bool | np.bool_):
            raise ArgumentTypeError.expecting("antialias", "be True or False", repr(self.antialias))
        object.__setattr__(self, "feature_angle", angle(self.feature_angle, "feature_angle"))
        if isinstance(self.fill, Iterator):
            object.__setattr__(self, "fill", list(self.fill))  # is gone through several times
        _require_width(self.line_width, "line_width")
        if self.point_size is not None:
            _require_width(self.point_size, "point_size")
        for name in ("alpha", "depth_cue"):
            if not 0.0 <= as_float(getattr(self, name), name) <= 1.0:
                raise ArgumentError.expecting(name, "lie in [0, 1]", f"{getattr(self, name):g}")
        given = [name for name in _COLORS_OF_THEIR_OWN if getattr(self, name) is not None]
        if len(given) > 1:
            raise ArgumentError(f"of colours, one kind can be given, got {' and '.join(given)}")

    @property
    def world_from_model(self) -> Float64Array:
        """The matrices of the instances: (k, 4, 4), k > 0."""
        if self.transform is None:
            return np.eye(4)[np.newaxis]
        matrices = as_square_matrices(self.transform, "transform", 4).reshape(-1, 4, 4)
        if len(matrices) == 0:
            raise ArgumentError.expecting("transform", "hold at least one matrix", "none")
        return matrices


Models: TypeAlias = Model | Layer | Scene | Sequence[Model | Layer | Scene]

_COLORS_OF_THEIR_OWN = ("face_colors", "edge_colors", "vertex_colors", "scalars")
_STYLE_NAMES = frozenset(field.name for field in fields(Layer)) - {"model"}


def is_point_array(model: object) -> TypeGuard[npt.NDArray[Any]]:
    """Return whether a model is an array, of NumPy or of what it takes for one."""
    return hasattr(model, "__array__") and not isinstance(model, _MODEL_TYPES)


def mesh_from_points(points: npt.NDArray[Any]) -> Mesh:
    """Return the mesh of `points` (n, 3) without faces; raise errors that call them the model."""
    array = as_host_array(points, "model")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArgumentError.expecting("model", "have shape (n, 3)", array.shape)
    return Mesh(as_real_array(array, "model"))


def as_layers(models: Models, style: Style) -> list[Layer]:
    """Return the layers of a picture; `style` goes for the models that bring none of their own.

    Raises `ArgumentError` for no models, `ArgumentTypeError` for a keyword that is not in `Style`.
    """
    unknown = style.keys() - _STYLE_NAMES
    if unknown:
        raise ArgumentTypeError(f"unexpected keyword argument {min(unknown)!r}")
    if isinstance(models, Layer) and style:
        raise ArgumentError(f"{min(style)} must be given to the Layer itself")
    several = [models] if isinstance(models, str) or not isinstance(models, Sequence) else models
    layers = [layer for model in several for layer in _layers(model, style)]
    if not layers:
        raise ArgumentError.expecting("models", "hold at least one model", "none")
    return layers


def _layers(model: Model | Layer | Scene, style: Style) -> list[Layer]:
    if isinstance(model, Layer):
        return [model]
    if isinstance(model, Scene):
        return [_instances(shown, style) for shown in model.layers()]
    return [Layer(model, **style)]


def _instances(shown: Instances, style: Style) -> Layer:
    """Return the layer of a scene's model: in its own style first; what `style` transforms is the whole scene."""
    unknown = shown.style.keys() - _STYLE_NAMES
    if unknown:
        raise ArgumentTypeError(f"{shown.node!r} shows a model with an unexpected keyword argument {min(unknown)!r}")
    with prefix_errors(repr(shown.node)):
        layer = Layer(shown.model, **{"name": shown.node, **style, **shown.style})
    return replace(layer, transform=(layer.world_from_model[:, np.newaxis] @ shown.transform).reshape(-1, 4, 4))


def _require_width(value: float, name: str) -> None:
    if not 0.0 < as_float(value, name) <= MAX_LINE_WIDTH_PX:
        raise ArgumentError.expecting(name, f"be positive and at most {MAX_LINE_WIDTH_PX:g}", f"{value:g}")
