"""Layers: the models of a picture, where each stands, and the style that it is drawn in."""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from inspect import Parameter, Signature
from typing import Any, Literal, Self, TypeAlias, TypedDict, TypeGuard

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_int, as_real_array, as_square_matrices
from .._core.error_context import prefix_errors
from .._core.masked import Mask, drop_hidden_rows, find_hidden_rows, require_whole
from .._core.pictured import Pictured
from .._core.public import public
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array, MatrixLike, StrPath
from ..compute._arrays import as_host_array
from ..compute.mesh_buffer import MeshBuffer
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.edges import EdgesLike, as_crease_angle, has_brep_faces, list_edge_parts
from ..geometry.foreign_meshes import mesh_of_other_library
from ..geometry.instances import Instances
from ..geometry.mesh import Mesh
from ..geometry.nodes import SupportsAsModel
from ..geometry.scene import Scene
from ..geometry.trimesh_scenes import is_trimesh_scene
from ..imaging.colormaps import find_limits
from ..imaging.colors import ColorLike, to_rgba
from .attribute_colors import AXES, FILE, find_scalars, resolve_fill, resolve_line_colors, resolve_scalars
from .dash_patterns import DashLike, as_dash_pattern
from .enums import HIDDEN_STYLES, SHADE, SHADINGS, HiddenStyle, Shading
from .label_options import NAMES, InstanceNames, LabelsLike, check_labels, drop_hidden_labels
from .lengths import to_pixels
from .point_array import PointArray, as_point_array
from .section_options import HatchLike, SectionLike, parse_hatch, parse_section

Model: TypeAlias = Mesh | npt.NDArray[Any] | PointBuffer | SupportsAsModel | StrPath | PointArray

SHADED_FILL = "#dfe3e8"
_MODEL_TYPES = (Mesh, PointBuffer, PointArray, str, os.PathLike)
AUTO: Literal["auto"] = "auto"  # a line width
HIDDEN_STYLE_KEYS = ("color", "line_width", "dash")
MAX_LINE_WIDTH_PX = 1e6  # beyond it, single precision loses the sides of the line


class Style(TypedDict, total=False):
    """The style keywords of `render` and its kin: those of `Layer`, which describes them."""

    transform: MatrixLike | None
    name: str | None
    edges: EdgesLike | None
    feature_angle: float
    hidden: HiddenStyle | None
    hidden_style: Mapping[str, Any] | None
    line_width: float | str
    dash: DashLike
    antialias: bool
    color: ColorLike
    face_colors: npt.ArrayLike | None
    edge_colors: npt.ArrayLike | None
    vertex_colors: npt.ArrayLike | None
    scalars: npt.ArrayLike | str | None
    cmap: Any
    clim: Sequence[float] | None
    alpha: float
    depth_cue: float
    fill: Any
    shading: Shading
    point_size: float | str | None
    max_points: int | None
    labels: LabelsLike | None
    section: SectionLike | None
    hatch: HatchLike
    colorbar: bool | str


@public
@dataclass(frozen=True, eq=False, repr=False)
class Layer(Pictured):
    """A model in a picture, where it stands, and how it is drawn.

    Parameters
    ----------
    model : Mesh, (n, 3) numbers, PointBuffer, Springs or path
        What is drawn. A `Mesh` is made of an array of points; one of more than a hundred thousand is not copied, and
        must not change while the layer is used. A `PointBuffer` of shape (n, 3) is drawn from the device memory that
        holds it, a `MeshBuffer` with its edges and faces. A `Springs` is drawn as it is when the picture is made.
        Meshes, lines and points of trimesh, PyVista (PolyData), Open3D and meshio become meshes.
    transform : (4, 4) or (k, 4, 4) numbers, optional
        The matrix from the model to the world, or the matrices of k instances; the identity by default.
    name : str, optional
        The name of the model in vector pictures and in errors; the stem of a file's name by default.
    edges : "all", "feature", "boundary", "silhouette", "intersection", (m, 2) integers, or several in a list, optional
        The edges to draw; several names may be one text, "feature,silhouette". "feature" are the sharp edges and the
        boundary, "boundary" the edges of one face alone, "silhouette" the edges that the camera sees edge-on and the
        boundary, "intersection" the lines where bodies
        penetrate one another: other layers, other instances, or parts of the model that no edge connects; an array
        holds indices of points. By default all edges of a mesh, and none of a `PointBuffer`; of a mesh of STEP, the
        edges of the faces that it is made of, "feature", and the silhouette.
    feature_angle : float
        The least angle between two faces at a sharp edge, in degrees: of lines, and of `shading="smooth"`.
    hidden : "show", "remove", "dash" or "fade", optional
        What is done with edges behind faces, of this model or another. Dashes run on from edge to edge where the line
        turns by at most 50 degrees. The default is "show", or "remove" if `fill` is given. The faces of a layer hide
        others unless the layer shows all its edges; by default only opaque filled faces of other layers hide the lines
        and dots of one that is not filled. SVG and PDF leave out hidden lines that lie on other lines, where a layer
        has at most 65,536 segments of lines.
    hidden_style : dict, optional
        How hidden parts are drawn that differ from visible ones by more than dashes: "color", "line_width" and "dash",
        as these keywords take them. Where "color" or "line_width" is missing, it is that of visible parts; where "dash"
        is, dashes are as by default. It goes with `hidden="dash"`, which is then the default, and "fade".
        `{"color": "gray", "dash": None}` draws hidden parts as continuous lines.
    line_width : float, "auto" or str
        The width of lines in pixels, positive and at most 1e6, or with a unit: "0.35mm", "1pt", "2px", "0.1cm" or
        "0.1in", for the `dpi` of the picture; in SVG and PDF, a pixel is 1/96 inch. "auto" is 1.5 pixels, or less where
        the lines of a dense mesh would cover more than half of the pixels that it takes up, so that it does not become
        a blot.
    dash : sequence of float or str, optional
        Dashes of lines: lengths in line widths, such as (4, 2, 1, 2) or "4,2,1,2", of a dash, a gap, a dash and so
        on, at most eight dashes; or a line type of ISO 128-2 by its number or its name, such as "04" or
        "long-dashed-dotted". Dashes run on from edge to edge where the line turns by at most 50 degrees. By default
        lines are continuous. Hidden parts have dashes of their own, 4 widths long and 3 apart, if `hidden` is "dash";
        of widths below 1.5 pixels, as long as those of 1.5.
    antialias : bool
        If False, lines are one pixel wide whatever `line_width` says, and each pixel is on or off; that is fast.
    color : color
        The colour of lines and points: a name, "#rrggbb", or three or four numbers from 0 to 1. "face" draws the edges
        of each face in its own colour, from a cycle of ten; an edge that faces share has the colour of the last one.
        "file" takes the attribute "color" of the model, per point, corner or face, or the colours of its materials.
    face_colors : (f, 3) or (f, 4) numbers, or f colors, optional
        The colours of the edges of each face, in place of the cycle.
    edge_colors : (m, 3) or (m, 4) numbers, or m colors, optional
        The colour of each row of `Mesh.edges`, or of `edges` if that is an array.
    vertex_colors : (n, 3) or (n, 4) numbers, or n colors, optional
        The colour of each point, interpolated along the edges.
    scalars : (n,) numbers or str, optional
        A number per point, shown in the colours of `cmap`, or the name of an attribute of the model with one number per
        point or per face, such as "intensity"; "x", "y" and "z" are the coordinates unless attributes are called so.
    cmap : str or colormap
        The colormap for `scalars`: a name as matplotlib has them, such as "viridis" or "viridis_r", or a callable from
        (k,) numbers in [0, 1] to (k, 4) colours. With a name, NaN is transparent.
    clim : (2,) numbers, optional
        The scalars at both ends of the colormap; by default the smallest and the largest.
    alpha : float
        The opacity of all that is drawn, from 0 to 1. Filled faces become paler: of several at a pixel the nearest one
        alone is drawn, of whichever model, so that those behind it stay hidden. Models without a fill show through.
    depth_cue : float
        What the farthest point of the picture loses of its opacity, from 0 to 1; nearer points lose less, in proportion
        to their distance.
    fill : color, "face", (f, 3) or (f, 4) numbers, or f colors, optional
        The colour that faces are filled with; "face" takes the cycle of ten, and "file" the colours of the model as
        `color` does; "shade" is a light grey with `shading="flat"`, or "smooth" if that is given. By default faces are
        not filled.
    shading : "none", "flat" or "smooth"
        "flat" darkens each face that is filled the more, the more it turns away from a lamp at the eye: its colour
        times 0.3 + 0.7 |n · l|, with the normal n of the face and the direction l against that of the view. "smooth"
        takes normals at the corners, and what lies between them within the face: the attribute "normal" of the model
        where it has one, else the mean of the faces about a point that turn by at most `feature_angle` from one to the
        next, so that the edges of `edges="feature"` stay sharp. In SVG and PDF, the colour changes linearly across
        parts of faces so small that this shows the same.
    point_size : float or str, optional
        The diameter in pixels, or with a unit, of a dot at each point. By default there are no dots, but dots of 2
        pixels for models that have points alone.
    max_points : int, optional
        Of points that nothing joins, draw at most so many, for a quick look: of as many runs of points of equal length,
        in their order, one point at random, the same each time. Models with faces are drawn whole.
    labels : "names", "indices", n texts, or dict from points to texts, optional
        Texts beside points. "names" writes the name of the model over its centre, and in a scene the name of each node;
        "indices" the index of each point at the point; a sequence holds a text per point, "" or None for none; the keys
        of a dict are indices of points, or points (x, y, z) of the model's frame. No two texts overlap: the nearest
        point chooses first, and if some find no room, a `TextWarning` says how many. Of hidden points, labels are left
        out if `hidden` is "remove", and faded if it is "dash" or "fade"; by default opaque filled faces of other models
        hide them. Names are always shown.
    colorbar : bool or str
        Whether a bar at the right of the picture says which numbers the colours of `scalars` stand for; a text is its
        title, by default the name of the attribute. Layers of the same title, limits and colormap share one.
    section : (point, normal), optional
        A plane of the world, by a point (3,) and a normal (3,) or an axis such as "+X", that cuts the model. What
        lies before it, where the normal points, is removed, the outline of the cut is drawn twice as wide as other
        lines, and the areas that closed bodies leave in the plane are filled as faces are, and hide what is behind
        them. `hidden` is "remove" by default then.
    hatch : bool, "auto", float or (float, float), optional
        True or "auto" hatches these areas by lines at 45 degrees, and at 135 degrees in every other body; a number is
        another angle in degrees, and a pair (degrees, spacing) says how far apart the lines are, in units of the
        world. They are half as wide as other lines.

    Raises
    ------
    ArgumentError
        An argument has an impossible value, or more than one of `face_colors`, `edge_colors`, `vertex_colors` and
        `scalars` is given. Arrays are checked when the layer is drawn.
    ArgumentTypeError
        An argument has a wrong type: "model must be a Mesh, a Scene, a path, points, or ..., got int".

    Notes
    -----
    Of the lines of a layer, and of its dots, nearer ones lie over farther ones.
    """

    model: Model
    _: KW_ONLY
    transform: MatrixLike | None = None
    name: str | None = None
    edges: EdgesLike | None = None
    feature_angle: float = 30.0
    hidden: HiddenStyle | None = None
    hidden_style: Mapping[str, Any] | None = None
    line_width: float | str = 1.5
    dash: DashLike = None
    antialias: bool = True
    color: ColorLike = "black"
    face_colors: npt.ArrayLike | None = None
    edge_colors: npt.ArrayLike | None = None
    vertex_colors: npt.ArrayLike | None = None
    scalars: npt.ArrayLike | str | None = None
    cmap: Any = "viridis"
    clim: Sequence[float] | None = None
    alpha: float = 1.0
    depth_cue: float = 0.0
    fill: Any = None
    shading: Shading = "none"
    point_size: float | str | None = None
    max_points: int | None = None
    labels: LabelsLike | None = None
    section: SectionLike | None = None
    hatch: HatchLike = None
    colorbar: bool | str = False

    def __new__(cls, *_: object, **given: object) -> Self:
        """Return a layer to be filled; raise ArgumentTypeError for an unknown keyword, with a suggestion."""
        unknown = given.keys() - _STYLE_NAMES - {"model"}
        if unknown:
            raise ArgumentTypeError(f"unexpected keyword argument {_describe_keyword(min(unknown))}")
        return super().__new__(cls)

    def __repr__(self) -> str:
        _, *styles = fields(self)
        given = {each.name: getattr(self, each.name) for each in styles}
        named = [
            f"{each.name}={_show(given[each.name])}" for each in styles if not _is_same(given[each.name], each.default)
        ]
        return f"{type(self).__name__}({', '.join([_show(self.model), *named])})"

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", as_own_model(self.model))
        if is_point_array(self.model):
            if (hidden_rows := find_hidden_rows(self.model)) is not None and hidden_rows.ndim == 1:
                self._drop_styles_of(hidden_rows)
            object.__setattr__(self, "model", as_point_array(self.model) or mesh_from_points(self.model))
        if not isinstance(self.model, (*_MODEL_TYPES, SupportsAsModel)):
            raise ArgumentTypeError.expecting(
                "model",
                "be a Mesh, a Scene, a path, points, or a mesh of trimesh, PyVista, Open3D or meshio",
                type(self.model).__name__,
            )
        if not isinstance(self.name, str | None):
            raise ArgumentTypeError.expecting("name", "be a string", repr(self.name))
        hidden: object = self.hidden
        if not (hidden is None or (isinstance(hidden, str) and hidden in HIDDEN_STYLES)):
            names = ", ".join(map(repr, HIDDEN_STYLES))
            hint = did_you_mean(self.hidden, HIDDEN_STYLES) if isinstance(self.hidden, str) else ""
            raise ArgumentError.expecting("hidden", f"be one of {names}", f"{self.hidden!r}{hint}")
        shading: object = self.shading
        if not (isinstance(shading, str) and shading in SHADINGS):
            names = ", ".join(map(repr, SHADINGS))
            hint = did_you_mean(shading, SHADINGS) if isinstance(shading, str) else ""
            raise ArgumentError.expecting("shading", f"be one of {names}", f"{shading!r}{hint}")
        if isinstance(self.fill, str) and self.fill == SHADE:
            object.__setattr__(self, "fill", SHADED_FILL)
            object.__setattr__(self, "shading", "flat" if self.shading == "none" else self.shading)
        if not isinstance(self.antialias, bool | np.bool_):
            raise ArgumentTypeError.expecting("antialias", "be True or False", repr(self.antialias))
        object.__setattr__(self, "feature_angle", as_crease_angle(self.feature_angle, "feature_angle"))
        if isinstance(self.fill, Iterator):
            object.__setattr__(self, "fill", list(self.fill))  # it is read several times
        if not is_auto(self.line_width):
            _require_width(self.line_width, "line_width", also=f"{AUTO!r}, ")
        object.__setattr__(self, "dash", as_dash_pattern(self.dash, "dash") or None)
        if self.section is not None:
            object.__setattr__(self, "section", parse_section(self.section))
        object.__setattr__(self, "hatch", parse_hatch(self.hatch, has_section=self.section is not None))
        if self.hidden_style is not None:
            object.__setattr__(self, "hidden_style", self._parse_hidden_style(self.hidden_style))
        if self.point_size is not None:
            _require_width(self.point_size, "point_size")
        if self.max_points is not None and as_int(self.max_points, "max_points") < 1:
            raise ArgumentError.expecting("max_points", "be at least 1", self.max_points)
        object.__setattr__(self, "labels", check_labels(self.labels))
        if not isinstance(self.colorbar, bool | np.bool_ | str):
            raise ArgumentTypeError.expecting("colorbar", "be True, False or a title", repr(self.colorbar))
        has_limits = self.face_colors is not None and self.clim is not None  # as scalars per face are resolved
        if self.colorbar is not False and self.scalars is None and not has_limits:
            raise ArgumentError.expecting("colorbar", "come with scalars", reason="there are no numbers to explain")
        for name in ("alpha", "depth_cue"):
            if not 0.0 <= as_float(getattr(self, name), name) <= 1.0:
                raise ArgumentError.expecting(name, "lie in [0, 1]", f"{getattr(self, name):g}")
        given = [name for name in _COLOR_ARRAYS if getattr(self, name) is not None]
        if len(given) > 1:
            raise ArgumentError(f"at most one of {', '.join(_COLOR_ARRAYS)} may be given, got {' and '.join(given)}")
        if self.edges is None and self.edge_colors is None and isinstance(self.model, Mesh):
            is_by_face = self.face_colors is not None or (isinstance(self.color, str) and self.color in ("face", FILE))
            if has_brep_faces(self.model) and not is_by_face:  # whose triangles nobody has drawn
                object.__setattr__(self, "edges", ["feature", "silhouette"])
        if isinstance(self.model, PointArray):
            self._resolve_coordinates(self.model)
        elif isinstance(self.model, Mesh | MeshBuffer):
            self._resolve_attributes(self.model)

    def _parse_hidden_style(self, given: object) -> dict[str, Any]:
        """Return the style of hidden parts, checked."""
        expected = f"have keys among {', '.join(HIDDEN_STYLE_KEYS)}"
        if not isinstance(given, Mapping):
            raise ArgumentTypeError.expecting("hidden_style", f"be a dict, and {expected}", type(given).__name__)
        unknown = next((key for key in given if key not in HIDDEN_STYLE_KEYS), None)
        if unknown is not None:
            hint = did_you_mean(unknown, HIDDEN_STYLE_KEYS) if isinstance(unknown, str) else ""
            raise ArgumentError.expecting("hidden_style", expected, f"{unknown!r}{hint}")
        if self.hidden not in (None, "dash", "fade"):
            raise ArgumentError.expecting("hidden_style", "go with hidden='dash' or 'fade'", repr(self.hidden))
        style = dict(given)
        if "color" in style:
            to_rgba(style["color"], "hidden_style['color']")
        if "line_width" in style:
            _require_width(style["line_width"], "hidden_style['line_width']")
        if "dash" in style:
            style["dash"] = as_dash_pattern(style["dash"], "hidden_style['dash']")
        return style

    def _resolve_attributes(self, model: Mesh | MeshBuffer) -> None:
        """Put the attributes of the model in place of their names; for a path, its layer does so when it is loaded."""
        changes: dict[str, Any] = {}
        mesh = model if isinstance(model, Mesh) else model.topology
        if isinstance(self.scalars, str):
            mesh = model if isinstance(model, Mesh) else model.mesh  # whose coordinates may be the scalars
            changes |= resolve_scalars(mesh, self.scalars, self.cmap, self.clim)
            if self.colorbar is not False:
                values, _ = find_scalars(mesh, self.scalars)
                changes |= self._name_color_bar() | {"clim": _limits_of(values, self.clim)}
        if _is_file(self.color):
            has_colors = any(getattr(self, name) is not None for name in _COLOR_ARRAYS)
            changes |= {"color": "black"} | ({} if has_colors else resolve_line_colors(mesh))
        if _is_file(self.fill):
            changes["fill"] = resolve_fill(mesh)
        for name, value in changes.items():
            object.__setattr__(self, name, value)

    def _resolve_coordinates(self, points: PointArray) -> None:
        """Put a coordinate in place of its name; an array has no other attributes, as its first point can say."""
        if isinstance(self.scalars, str) and self.scalars in AXES:
            changes = self._name_color_bar()
            changes["scalars"] = points.array[:, AXES.index(self.scalars)]
            for name, value in changes.items():
                object.__setattr__(self, name, value)
        elif isinstance(self.scalars, str) or _is_file(self.color) or _is_file(self.fill):
            self._resolve_attributes(mesh_from_points(points.array[:1]))

    def _name_color_bar(self) -> dict[str, Any]:
        """Return the title of a colour bar that has none, the name of the scalars."""
        return {"colorbar": self.scalars} if self.colorbar is True else {}

    def scalar_limits(self) -> tuple[float, float]:
        """Return the numbers at both ends of the colormap, of a layer with scalars.

        Returns
        -------
        (float, float)
        """
        return _limits_of(self.scalars, self.clim)

    def _drop_styles_of(self, hidden: Mask) -> None:
        """Leave out what the keywords say of points that the model's mask hides."""
        if self.edges is not None and any(not isinstance(part, str) for part in list_edge_parts(self.edges)):
            raise ArgumentError.expecting("edges", "not be given by indices for a masked array of points")
        for name in ("scalars", "vertex_colors"):
            value = getattr(self, name)
            if value is not None and not isinstance(value, str) and len(value) == len(hidden):
                shown = value[~hidden] if isinstance(value, np.ndarray) else [value[i] for i in np.flatnonzero(~hidden)]
                object.__setattr__(self, name, shown)
        object.__setattr__(self, "labels", drop_hidden_labels(self.labels, hidden))

    @property
    def world_from_model(self) -> Float64Array:
        """The matrices from the model to the world: (k, 4, 4) float64, one per instance, k > 0.

        Raises
        ------
        ArgumentError
            "transform must have shape (4, 4), got (3, 3)", or it holds no matrix.
        """
        if self.transform is None:
            return np.eye(4)[np.newaxis]
        matrices = as_square_matrices(self.transform, "transform", 4).reshape(-1, 4, 4)
        if len(matrices) == 0:
            raise ArgumentError.expecting("transform", "hold at least one matrix", "none")
        return matrices


def _is_same(value: Any, default: Any) -> bool:
    return value is default or (
        isinstance(default, bool | float | str) and isinstance(value, type(default)) and bool(value == default)
    )


def _show(value: Any) -> str:
    """Return the text of a value, of arrays their shape alone."""
    return f"<array {value.shape}>" if isinstance(value, np.ndarray) else repr(value)


def _limits_of(scalars: Any, clim: Sequence[float] | None) -> tuple[float, float]:
    """Return the numbers at both ends of a colormap; masked ones have no colour."""
    if not np.ma.isMaskedArray(scalars):
        require_whole(scalars, "scalars")
    values = np.ma.filled(np.ma.asarray(scalars, np.float64), np.nan) if np.ma.isMaskedArray(scalars) else scalars
    return find_limits(np.zeros(0) if values is None else np.asarray(values, np.float64), clim)


def as_own_model(model: Any) -> Any:
    """Return the mesh or the scene of a model of another library; anything else as it is."""
    if is_trimesh_scene(model):
        return Scene.from_trimesh(model)
    mesh = mesh_of_other_library(model)
    return model if mesh is None else mesh


def at_present(layer: Layer) -> Layer:
    """Return the layer with what is drawn of its model at present, if that knows."""
    model = layer.model
    # Asking for the types first takes a tenth of asking for a method.
    if isinstance(model, _MODEL_TYPES) or not isinstance(model, SupportsAsModel):
        return layer
    return replace(layer, model=model.as_model())


Models: TypeAlias = Model | Layer | Scene | Sequence[Model | Layer | Scene]


def style_parameters() -> list[Parameter]:
    """Return the style keywords and their defaults, as signatures show them."""
    _, *styles = fields(Layer)
    return [Parameter(each.name, Parameter.KEYWORD_ONLY, default=each.default) for each in styles]


# `inspect` would show the parameters of `__new__`, which takes anything.
Layer.__signature__ = Signature(  # type: ignore[attr-defined]
    [Parameter("model", Parameter.POSITIONAL_OR_KEYWORD), *style_parameters()]
)

_COLOR_ARRAYS = ("face_colors", "edge_colors", "vertex_colors", "scalars")
_STYLE_NAMES = frozenset(field.name for field in fields(Layer)) - {"model"}
_PICTURE_NAMES = frozenset({"background", "camera", "device", "rasterizer", "size"})


def _describe_keyword(name: str, others: Iterable[str] = _PICTURE_NAMES) -> str:
    """Return an unknown keyword, and the one of a style or of `others` that it may be a misspelling of."""
    return f"{name!r}{did_you_mean(name, sorted(_STYLE_NAMES.union(others)))}"


def require_style(keywords: Iterable[str], others: Iterable[str] = _PICTURE_NAMES) -> None:
    """Raise ArgumentTypeError for a keyword that is not in `Style`; it may be a misspelling of `others` too."""
    unknown = set(keywords) - _STYLE_NAMES
    if unknown:
        raise ArgumentTypeError(f"unexpected keyword argument {_describe_keyword(min(unknown), others)}")


def _is_file(color: object) -> bool:
    return isinstance(color, str) and color == FILE


def is_point_array(model: object) -> TypeGuard[npt.NDArray[Any]]:
    """Say whether a model is an array, of NumPy or with `__array__`."""
    return hasattr(model, "__array__") and not isinstance(model, _MODEL_TYPES)


def mesh_from_points(points: npt.NDArray[Any]) -> Mesh:
    """Return the mesh of `points` (n, 3), without faces; errors call them the model."""
    array = as_host_array(drop_hidden_rows(points), "model")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArgumentError.expecting("model", "have shape (n, 3)", array.shape)
    return Mesh(as_real_array(array, "model"))


def as_layers(models: Models, style: Style) -> list[Layer]:
    """Return the layers of a picture; `style` is for the models that have none of their own.

    Raises `ArgumentError` if there are no models, `ArgumentTypeError` for a keyword that is not in `Style`.
    """
    require_style(style)
    if isinstance(models, Layer) and style:
        raise ArgumentError(f"{min(style)} must be given to the Layer itself")
    sequence = [models] if isinstance(models, str) or not isinstance(models, Sequence) else models
    layers = [layer for model in sequence for layer in _layers(model, style)]
    if not layers:
        raise ArgumentError.expecting("models", "hold at least one model", "none")
    return layers


def _layers(given: Model | Layer | Scene, style: Style) -> list[Layer]:
    model = as_own_model(given)
    if isinstance(model, Layer):
        return [model]
    if isinstance(model, Scene):
        return [_layer_of_instances(shown, style) for shown in model.layers()]
    return [Layer(model, **style)]


def _layer_of_instances(shown: Instances, style: Style) -> Layer:
    """Return the layer of a scene's model: its own style precedes `style`, whose transform is for the whole scene."""
    unknown = shown.style.keys() - _STYLE_NAMES
    if unknown:
        raise ArgumentTypeError(
            f"{shown.node!r} shows a model with an unexpected keyword argument {_describe_keyword(min(unknown))}"
        )
    with prefix_errors(repr(shown.node)):
        layer = Layer(shown.model, **{"name": shown.node, **style, **shown.style})
    worlds = (layer.world_from_model[:, np.newaxis] @ shown.transform).reshape(-1, 4, 4)
    labels = layer.labels
    if isinstance(labels, str) and labels == NAMES:
        labels = InstanceNames(shown.nodes * len(layer.world_from_model))
    return replace(layer, transform=worlds, labels=labels)


def is_auto(line_width: object) -> bool:
    """Say whether a width of lines depends on how many there are."""
    return isinstance(line_width, str) and line_width == AUTO


def dot_diameter(layer: Layer) -> float | None:
    """Return the diameter in pixels of the dots that a layer asks for."""
    return None if layer.point_size is None else to_pixels(layer.point_size, "point_size")


def with_lengths_in_pixels(layer: Layer, px_per_inch: float) -> Layer:
    """Return a layer whose widths of lines and diameters of dots are numbers of pixels, or `AUTO`."""
    changes: dict[str, Any] = {}
    if isinstance(layer.line_width, str) and not is_auto(layer.line_width):
        changes["line_width"] = to_pixels(layer.line_width, "line_width", px_per_inch)
    if isinstance(layer.point_size, str):
        changes["point_size"] = to_pixels(layer.point_size, "point_size", px_per_inch)
    if layer.hidden_style is not None and isinstance(layer.hidden_style.get("line_width"), str):
        width = to_pixels(layer.hidden_style["line_width"], "hidden_style['line_width']", px_per_inch)
        changes["hidden_style"] = {**layer.hidden_style, "line_width": width}
    return replace(layer, **changes) if changes else layer


def _require_width(value: float | str, name: str, *, also: str = "") -> None:
    pixels = to_pixels(value, name, also=also)
    if not 0.0 < pixels <= MAX_LINE_WIDTH_PX:
        got = value if isinstance(value, str) else f"{value:g}"
        raise ArgumentError.expecting(name, f"be positive and at most {MAX_LINE_WIDTH_PX:g}", got)
