"""Cloud source: the geometry of points that nothing joins and that are drawn from where they are, however many."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from ..gpu.device import GpuDevice
from .boxes import box_in_world, world_positions
from .cloud_points import CloudPoints, find_extremes
from .geometry_source import GeometrySource
from .layer import Layer, dot_diameter
from .layer_colors import colors_by_face
from .point_array import MIN_CLOUD_POINTS, PointArray, require_finite
from .point_colors import Coloring, PointColors, point_colors

MAX_DOT_PX = (
    100.0  # in diameter; an invocation that goes over the pixels of four larger ones could be ended by a driver
)
BOUNDS_FUNCTIONS = np.eye(4)[:3]


class CloudSource:
    """The points of a cloud, on the device that `open_device` returns, and the few of them that decide on a camera."""

    n_faces = 0
    mesh: Mesh | None = None

    def __init__(
        self, positions: npt.NDArray[Any], name: str, number: int, owner: object, open_device: Callable[[], GpuDevice]
    ) -> None:
        self.name = name
        self.n_points = len(positions)
        self.owner = owner
        self._open_device = open_device
        self.points = CloudPoints(positions, number, owner if isinstance(owner, Mesh) else None)
        self._corners: Float64Array | None = None
        self.colors = PointColors(Coloring.UNIFORM)

    def choose_colors(self, layer: Layer) -> None:
        """Take the colours that `layer` asks for, before the points are looked at. Raises as `point_colors` does."""
        self.colors = point_colors(layer, self.points.positions)

    def framing_points(self, world_from_model: Float64Array, axes: Float64Array | None = None) -> Float64Array:
        """Return points of the world (p, 3): those that reach farthest along axes (a, 3), or boxes around instances."""
        if axes is None or len(world_from_model) > 1:
            return self.box_corners(world_from_model)
        functions = axes @ world_from_model[0, :3] / world_from_model[0, 3, 3]
        return world_positions(self._reach(functions), world_from_model[0])

    def points_before(self, functions: Float64Array, world_from_model: Float64Array) -> Float64Array:
        """Return points of the world (p, 3) at which functions of (point, 1) are extreme where the first is positive.

        functions : (f, 4)
        """
        if len(world_from_model) > 1:
            return self.box_corners(world_from_model)
        found = find_extremes(self.points, self._open_device(), functions @ world_from_model[0], only_positive=True)
        return world_positions(self._at(found.rows), world_from_model[0])

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return none."""
        return np.empty((0, 3), np.int64), np.empty(0, np.int64)

    def unbounded_points(self, _world_from_model: Float64Array) -> Float64Array:
        """Return none: all points are finite."""
        return np.empty((0, 3))

    def box_corners(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the box of each instance."""
        return box_in_world(self.bounds, world_from_model)

    @property
    def bounds(self) -> Float64Array:
        """The smallest and the largest coordinates: (2, 3)."""
        if self._corners is None:
            self._reach(np.empty((0, 4)))
        assert self._corners is not None  # noqa: S101  # for mypy: `_reach` has set it
        return self._corners

    def _reach(self, functions: Float64Array) -> Float64Array:
        """Return the points at which functions (f, 4) are extreme; all points are read, which gives the bounds as well.

        Raises `MeshError` if a coordinate is not finite.
        """
        wanted = functions if self._corners is not None else np.concatenate([BOUNDS_FUNCTIONS, functions])
        found = find_extremes(self.points, self._open_device(), wanted)
        if found.n_non_finite:
            require_finite(self.points.positions)
            raise ArgumentError.expecting("model", "have coordinates that single precision can tell apart")
        points = self._at(found.rows)
        if self._corners is None:
            self._corners = np.stack([points.min(axis=0), points.max(axis=0)])
        return points

    def _at(self, rows: npt.NDArray[np.int64]) -> Float64Array:
        return np.asarray(self.points.positions[rows], np.float64)


Source: TypeAlias = GeometrySource | CloudSource


def is_cloud(layer: Layer) -> bool:
    """Say whether a layer shows many points that nothing joins, in dots that the stages for clouds can draw."""
    model = layer.model
    if isinstance(model, Mesh):
        if model.n_faces or model.n_points < MIN_CLOUD_POINTS:
            return False
    elif not isinstance(model, PointArray):
        return False
    if layer.edges is not None or layer.fill is not None or layer.edge_colors is not None or colors_by_face(layer):
        return False
    return _is_affine(layer.world_from_model) and (dot_diameter(layer) or 0.0) <= MAX_DOT_PX


def _is_affine(matrices: Float64Array) -> bool:
    return bool((matrices[:, 3, :3] == 0.0).all() and (matrices[:, 3, 3] > 0.0).all())
