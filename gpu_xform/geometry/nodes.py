"""Nodes of scenes: a name, a matrix, and the models that are shown there."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array, as_square_matrices, as_square_matrix
from .._core.types import Float64Array, MatrixLike, StrPath
from ..errors import ArgumentError, ArgumentTypeError
from ..matrices._affine import require_finite
from .deformable_mesh import DeformableMesh
from .foreign_meshes import mesh_of_other_library
from .mesh import Mesh


class PointsOnDevice(Protocol):
    """The part of a `PointBuffer` that scenes use; its folder comes after this one."""

    @property
    def shape(self) -> tuple[int, int]:
        """The number of points, and of their coordinates."""
        ...

    def device_points(self) -> Any:
        """Return the points on the device."""
        ...


@runtime_checkable
class SupportsAsModel(Protocol):
    """An object that knows what is drawn of it, such as `Springs`."""

    def as_model(self) -> Any:
        """Return what is drawn of it at present: a Mesh or a PointBuffer."""
        ...


SceneModel: TypeAlias = Mesh | DeformableMesh | npt.NDArray[Any] | PointsOnDevice | SupportsAsModel | StrPath


class Shown(NamedTuple):
    """A model, and its style: keywords of `render`."""

    model: Any
    style: Mapping[str, Any]


class Node:
    """A node of a scene: a name, a matrix, and any number of models. `Scene.add` makes it."""

    # Of the class, so that scenes pickled before there were such have them.
    _is_visible = True
    _weights: Float64Array | None = None
    _instances: Float64Array | None = None
    _metadata: Mapping[str, Any] = MappingProxyType({})

    def __init__(self, name: str, parent: str | None, transform: Float64Array) -> None:
        self._name = name
        self._parent = parent
        self._transform = transform
        self._models: Sequence[Shown] = ()

    @property
    def name(self) -> str:
        """The name, unique in the scene."""
        return self._name

    @property
    def parent(self) -> str | None:
        """The name of the parent node; None for the world. `Scene.move` changes it."""
        return self._parent

    @property
    def transform(self) -> Float64Array:
        """The matrix from this node to its parent: (4, 4) float64, read-only.

        To change it, assign another matrix, or an object with `as_matrix()`.

        Raises
        ------
        ArgumentError
            If another shape, or a matrix with numbers that are not finite, is assigned.
        """
        return self._transform

    @transform.setter
    def transform(self, matrix: MatrixLike) -> None:
        """Replace the matrix."""
        self._transform = as_local_matrix(matrix, "transform")

    @property
    def models(self) -> tuple[Shown, ...]:
        """The models with their styles, in the order of the calls of `show`."""
        return tuple(self._models)

    @property
    def visible(self) -> bool:
        """Whether the models of this node, and of all that is in it, are drawn."""
        return self._is_visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        """Show or hide the node."""
        if not isinstance(visible, bool):
            raise ArgumentTypeError.expecting("visible", "be True or False", repr(visible))
        self._is_visible = visible

    @property
    def metadata(self) -> Mapping[str, Any]:
        """What else a file says of the node, by the name of its format, such as {"gltf": {"extras": ...}}."""
        return self._metadata

    @metadata.setter
    def metadata(self, metadata: Mapping[str, Any]) -> None:
        """Put other metadata in their place."""
        self._metadata = dict(metadata)

    @property
    def weights(self) -> Float64Array | None:
        """The morph weights of the models (t,), read-only; None for those of the models. Assign others to change them.

        ArgumentError is raised for another shape, a NaN, an infinity.
        """
        return self._weights

    @weights.setter
    def weights(self, weights: npt.ArrayLike | None) -> None:
        """Put other weights in their place."""
        self._weights = None if weights is None else as_weights(weights, "weights")

    @property
    def instances(self) -> Float64Array | None:
        """The matrices from copies of the models to this node: (k, 4, 4), read-only; None for one copy in its place.

        Assign others to change them; the nodes placed in this one have no copies.
        ArgumentError is raised for another shape, a NaN, an infinity.
        """
        return self._instances

    @instances.setter
    def instances(self, matrices: MatrixLike | None) -> None:
        """Put other matrices in their place."""
        if matrices is None:
            self._instances = None
            return
        self._instances = as_read_only(as_square_matrices(matrices, "instances", 4).reshape(-1, 4, 4))

    def show(self, model: SceneModel, **style: Any) -> None:
        """Add a model to this node.

        Parameters
        ----------
        model : Mesh, (n, 3) array of points, PointBuffer, or path of a model file
            The model, in the coordinates of this node.
        **style
            Keywords of `render` that say how the model is drawn.

        Raises
        ------
        ArgumentError
            If `transform` is among the keywords: the node has one already.
        """
        if "transform" in style:
            raise ArgumentError.expecting("transform", "be that of a node", reason="a model stands where its node is")
        if not isinstance(self._models, list):  # from `with_models`, or pickled before it was one
            self._models = [*self._models]
        own = mesh_of_other_library(model)
        self._models.append(Shown(model if own is None else own, style))

    def __repr__(self) -> str:
        return f"<Node {summarize_node(self)}>"


def _describe(model: object) -> str:
    return f"<array {model.shape}>" if isinstance(model, np.ndarray) else repr(model)


def summarize_node(node: Node) -> str:
    """Return the name of a node, and what it shows."""
    models = ", ".join(_describe(shown.model) for shown in node.models)
    return f"{node.name!r}: {models}" if models else repr(node.name)


def as_local_matrix(matrix: MatrixLike, argument: str) -> Float64Array:
    """Return a (4, 4) matrix, read-only."""
    return as_read_only(as_square_matrix(matrix, argument, 4))


def as_local_matrices(matrix: MatrixLike, argument: str) -> Float64Array:
    """Return (..., 4, 4) matrices, read-only."""
    return as_read_only(as_square_matrices(matrix, argument, 4))


def as_read_only(array: Float64Array) -> Float64Array:
    """Return an array of our own that cannot be written to any more."""
    array.flags.writeable = False
    return array


def share_instances(node: Node, matrices: Float64Array) -> None:
    """Give a node the matrices (k, 4, 4) that others have, finite and read-only ones, which are not copied."""
    node._instances = matrices


def as_weights(weights: npt.ArrayLike, argument: str) -> Float64Array:
    """Return (t,) morph weights, read-only."""
    factors = as_real_array(weights, argument)
    if factors.ndim != 1:
        raise ArgumentError.expecting(argument, "have shape (t,)", factors.shape)
    return as_read_only(factors)


def require_finite_world(matrix: Float64Array, node: Node) -> Float64Array:
    """Return the world matrix of a node; raise `ArgumentError` where it overflows."""
    return require_finite(matrix, f"the world matrix of {node.name!r}")
