"""Geometry sources: the points, edges and faces of a layer's model, a mesh or a point buffer, for the device."""

import os
from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..compute.mesh_buffer import MeshBuffer
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError
from ..geometry.edges import (
    as_index_pairs,
    compute_plane_normals,
    find_edge_faces,
    is_drawable,
    is_single_array,
    list_edge_parts,
    resolve_edges,
    split_silhouette,
)
from ..geometry.mesh import Mesh, count_edges, pack_edges, pack_pairs
from ..geometry.triangulation import triangulate
from ..gpu.chunking import align_points
from ..gpu.device import GpuDevice
from ..gpu.device_points import DevicePoints
from ..gpu.layouts import CANDIDATE
from .boxes import box_corners, box_in_world, corners_in_world, join_points, world_positions
from .layer import Layer, at_present
from .layer_colors import colors_by_face
from .point_array import PointArray
from .silhouettes import NO_FACE
from .tangent_edges import find_tangent_edges

MAX_SAMPLED_EDGES = 1 << 9
PACKED_AT_ONCE = 1 << 16  # points
MAX_BOUNDING_POINTS = 1 << 10  # of larger models, the corners of their box bound the drawable


class EdgeSource(NamedTuple):
    """Edges that are found only when they are asked for, because a device may hold them already.

    find : returns (m, 2)
    color_rows : returns the row of colours of each edge that was found, (m,); None if they are in order
    n_colors : rows of colours that edge_colors must have
    key : under which a device keeps what was found; None for edges that are given for one picture
    pack : returns what `find` does as uint32, without keeping more; None if it is as well to convert that
    """

    find: Callable[[], IndexArray]
    color_rows: Callable[[IndexArray], IndexArray] | None
    n_colors: int
    key: Hashable | None
    pack: Callable[[], npt.NDArray[np.uint32]] | None = None


class SilhouetteCandidates(NamedTuple):
    """The edges among which each view finds its silhouette.

    find : returns `layouts.CANDIDATE` (m,)
    planes : returns the planes of the faces (f, 4) float32
    color_rows, key : as in `EdgeSource`
    planes_key : under which a device keeps the planes
    """

    find: Callable[[], npt.NDArray[np.void]]
    planes: Callable[[], npt.NDArray[np.float32]]
    color_rows: Callable[[IndexArray], IndexArray]
    key: Hashable | None
    planes_key: Hashable


class GeometrySource(Protocol):
    """Points in a model's frame, and the edges and faces that join them."""

    @property
    def name(self) -> str:
        """The model's name; may be empty."""
        ...

    @property
    def n_points(self) -> int:
        """The number of points."""
        ...

    @property
    def n_faces(self) -> int:
        """The number of faces."""
        ...

    @property
    def owner(self) -> object:
        """The object that the arrays kept on a device belong to."""
        ...

    @property
    def mesh(self) -> Mesh | None:
        """The mesh, if there are faces."""
        ...

    def edges(self, layer: Layer) -> EdgeSource:
        """Return the edges that `layer` draws in every view."""
        ...

    def silhouette_candidates(self, layer: Layer) -> SilhouetteCandidates | None:
        """Return the edges among which the silhouette is found; None if `layer` draws none."""
        ...

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return the faces as triangles (t, 3), and the face of each (t,)."""
        ...

    def framing_points(self, world_from_model: Float64Array) -> Float64Array:
        """Return points of the world (p, 3) that a camera must hold to hold all instances (k, 4, 4)."""
        ...

    def unbounded_points(self, world_from_model: Float64Array) -> Float64Array:
        """Return points of the world (p, 3) around what is drawn although `framing_points` has none for it."""
        ...

    def box_corners(self, world_from_model: Float64Array) -> Float64Array:
        """Return corners of boxes in the world (p, 3) that hold what `framing_points` and `unbounded_points` do."""
        ...

    def on_device(self, device: GpuDevice) -> tuple[DevicePoints, Float64Array]:
        """Return the points on `device`, and the (4, 4) matrix from them to the model's frame."""
        ...

    @property
    def sample_edges(self) -> Callable[[], Float64Array] | None:
        """What returns the ends of some edges, (k, 2, 3), in the frame of the points on a device; None if unknown."""
        ...


def geometry_source(layer: Layer) -> GeometrySource:
    """Return the geometry of the model of `layer`; a path is loaded."""
    layer = at_present(layer)
    model = layer.model
    if isinstance(model, MeshBuffer):
        # Which edges are sharp, or seen edge-on, depends on where the points are.
        needs_positions = not colors_by_face(layer) and {"feature", "silhouette"} & _edge_set_names(layer)
        name = layer.name or ""
        return MeshSource(model.mesh, name, layer) if needs_positions else MeshBufferSource(model, name, layer)
    if isinstance(model, PointBuffer):
        return BufferSource(model, layer.name or "")
    if isinstance(model, Mesh):
        return MeshSource(model, layer.name or "", layer)
    if isinstance(model, PointArray):
        return MeshSource(model.mesh, layer.name or "", layer)
    from ..formats import load_mesh

    path: str | os.PathLike[str] = model  # type: ignore[assignment]  # of an array, the layer has made a Mesh
    return MeshSource(load_mesh(path), Path(path).stem if layer.name is None else layer.name, layer)


class MeshSource:
    """The geometry of a mesh in the host's memory."""

    def __init__(self, mesh: Mesh, name: str, layer: Layer) -> None:
        self.mesh = mesh
        self.name = name
        self._shown = _shown_positions(mesh, layer)
        self.n_points = mesh.n_points
        self.n_faces = mesh.n_faces
        self.owner: object = mesh

    def edges(self, layer: Layer) -> EdgeSource:
        """Return the mesh's own edges if `layer.edges` is None, and in the order of the faces for colours by face."""
        mesh, edges, angle = self.mesh, layer.edges, layer.feature_angle
        if colors_by_face(layer):
            if edges is not None and any(not isinstance(part, str) or part != "all" for part in list_edge_parts(edges)):
                raise ArgumentError.expecting("edges", "be 'all' if each face has its own colour", repr(edges))
            # A shared edge has the colour of its last face: drawn once per face, it would mix both and be heavier.
            return EdgeSource(
                lambda: mesh.face_edges[mesh.last_face_edges],
                lambda _: mesh.face_edge_faces[mesh.last_face_edges],
                mesh.n_faces,
                "face edges",
            )
        if edges is None:
            return EdgeSource(lambda: mesh.edges, None, count_edges(mesh), "edges", lambda: pack_edges(mesh))
        rest, _ = split_silhouette(edges)
        if rest is None:
            return EdgeSource(lambda: np.empty((0, 2), np.int64), None, count_edges(mesh), "no edges")

        def find() -> IndexArray:
            return resolve_edges(mesh, rest, angle)

        if isinstance(rest, str):
            return EdgeSource(find, self._edge_indices, count_edges(mesh), ("edges", rest, angle))
        if is_single_array(edges):
            return EdgeSource(find, None, len(find()), None)
        return EdgeSource(find, self._edge_indices, count_edges(mesh), None)

    def silhouette_candidates(self, layer: Layer) -> SilhouetteCandidates | None:
        """Return the edges that are not drawn in every view, from which `extract_silhouette` chooses."""
        if layer.edges is None or colors_by_face(layer):
            return None
        rest, has_silhouette = split_silhouette(layer.edges)
        if not has_silhouette:
            return None
        mesh, angle = self.mesh, layer.feature_angle

        def find() -> npt.NDArray[np.void]:
            found = find_edge_faces(mesh)
            left = is_drawable(mesh, found)
            if rest is not None:
                drawn = resolve_edges(mesh, rest, angle)
                left = ~np.isin(pack_pairs(*found.edges.T), pack_pairs(*drawn.T))
            candidates = np.zeros(int(left.sum()), CANDIDATE)
            candidates["edge"] = found.edges[left]
            between_two = (found.n_faces == 2) & ~found.segments
            candidates["faces"] = np.where(between_two[:, None], found.faces, NO_FACE)[left]
            candidates["is_turned"] = found.inconsistent_winding[left]
            return candidates

        key = ("silhouette", rest, angle) if rest is None or isinstance(rest, str) else None
        return SilhouetteCandidates(find, self._planes, self._edge_indices, key, ("planes", *self._frame))

    def tangent_edges(self, layer: Layer) -> SilhouetteCandidates | None:
        """Return all edges that are drawn in every view, in their order, as candidates, if some may be silhouettes."""
        if layer.edges is None or colors_by_face(layer):
            return None
        rest, _ = split_silhouette(layer.edges)
        if not isinstance(rest, str) or rest == "all":
            return None
        mesh, angle = self.mesh, layer.feature_angle

        def find() -> npt.NDArray[np.void]:
            return find_tangent_edges(mesh, resolve_edges(mesh, rest, angle))

        key = ("tangent edges", rest, angle)
        return SilhouetteCandidates(find, self._planes, self._edge_indices, key, ("planes", *self._frame))

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return the polygons as triangles."""
        return triangulate(self.mesh.positions, self.mesh.offsets, self.mesh.indices)

    def framing_points(self, world_from_model: Float64Array) -> Float64Array:
        """Return all points that are shown with w > 0; for several instances, the corners of their boxes."""
        positions = self._shown
        if len(world_from_model) > 1 and len(positions) > 8:
            positions = box_corners(self._bounds)
        return join_points([world_positions(positions, matrix) for matrix in world_from_model])

    def unbounded_points(self, _world_from_model: Float64Array) -> Float64Array:
        """Return none: all points of a mesh are finite."""
        return np.empty((0, 3))

    def box_corners(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the box of each instance."""
        return corners_in_world(self._bounds, world_from_model)

    def on_device(self, device: GpuDevice) -> tuple[DevicePoints, Float64Array]:
        """Return the points in single precision, moved and scaled so that those that are shown lie in [-1, 1]^3.

        Single precision would lose the shape of a small model far from the origin, and cannot hold very large ones.
        """
        buffer = device.resource_cache.get(self.owner, ("points", *self._frame), self.pack_points)
        points = DevicePoints(buffer, self.n_points, np.dtype(np.float32), self.bounding_points)
        return points, self.model_from_points

    @property
    def model_from_points(self) -> Float64Array:
        """The (4, 4) matrix from the points on a device to the model's frame."""
        center, half_size = self._unit_cube
        model_from_unit = np.diag([half_size, half_size, half_size, 1.0])
        model_from_unit[:3, 3] = center
        return model_from_unit

    @property
    def bounding_points(self) -> Float64Array:
        """Points (p, 3), in the frame of those on a device, whose convex hull holds all that are shown."""
        center, half_size = self._unit_cube
        bounding = self._shown if len(self._shown) <= MAX_BOUNDING_POINTS else box_corners(self._bounds)
        inside: Float64Array = (bounding - center) / half_size
        return inside

    @property
    def sample_edges(self) -> Callable[[], Float64Array] | None:
        """What returns every so many-th edge of the mesh."""
        mesh = self.mesh

        def sample() -> Float64Array:
            center, half_size = self._unit_cube
            step = -(-count_edges(mesh) // MAX_SAMPLED_EDGES) or 1
            ends: Float64Array = (mesh.positions[mesh.edges[::step]] - center) / half_size
            return ends

        return sample

    @cached_property
    def _bounds(self) -> Float64Array:
        """The smallest and the largest coordinates of the points that are shown: (2, 3)."""
        if self._shown is self.mesh.positions:
            return self.mesh.bounds
        return np.stack([self._shown.min(axis=0), self._shown.max(axis=0)])

    @cached_property
    def _unit_cube(self) -> tuple[Float64Array, float]:
        """The centre and half the size of the cube around the points that are shown."""
        center = 0.5 * self._bounds[0] + 0.5 * self._bounds[1]
        return center, float((self._bounds[1] - center).max()) or 1.0

    @property
    def _frame(self) -> tuple[float, ...]:
        """What tells the frames of points on a device apart: layers may show different points of one mesh."""
        center, half_size = self._unit_cube
        return *center.tolist(), half_size

    def in_unit_cube(self, rows: IndexArray | slice = slice(None)) -> Float64Array:
        """Return the points, or some of them, in the frame of those on a device."""
        center, half_size = self._unit_cube
        with np.errstate(over="ignore"):  # of points that are not shown
            scaled: Float64Array = (self.mesh.positions[rows] - center) / half_size
        return scaled

    def pack_points(self, rows: IndexArray | slice = slice(None)) -> npt.NDArray[np.float32]:
        """Return the points, or some of them, as a device holds them; part by part, not to hold them twice as wide."""
        center, half_size = self._unit_cube
        positions = self.mesh.positions if isinstance(rows, slice) else self.mesh.positions[rows]
        packed = np.zeros((align_points(len(positions)), 3), np.float32)
        with np.errstate(over="ignore"):  # of points that are not shown
            for first in range(0, len(positions), PACKED_AT_ONCE):
                some = positions[first : first + PACKED_AT_ONCE]
                packed[first : first + len(some)] = (some - center) / half_size
        return packed

    def _planes(self) -> npt.NDArray[np.float32]:
        """Return the normal and the offset of each face, in the frame of the points on a device."""
        normals = compute_plane_normals(self.mesh, lambda: find_edge_faces(self.mesh))
        a_corner = self.mesh.indices[self.mesh.offsets[:-1]]
        offsets = -np.einsum("ij,ij->i", normals, self.in_unit_cube()[a_corner])
        return np.column_stack([normals, offsets]).astype(np.float32)

    def _edge_indices(self, pairs: IndexArray) -> IndexArray:
        """Return the index in `mesh.edges` of each of `pairs`."""
        known, keys = pack_pairs(*self.mesh.edges.T), pack_pairs(*pairs.T)
        indices = np.searchsorted(known, keys)
        unknown = np.flatnonzero(~np.isin(keys, known))
        if len(unknown):
            pair = tuple(pairs[unknown[0]].tolist())
            raise ArgumentError(
                f"edge_colors can go with one array of edges, or with edges of the model, which {pair} is not",
                argument="edge_colors",
                expected="go with one array of edges, or with edges of the model",
            )
        return indices


def _edge_set_names(layer: Layer) -> set[str]:
    parts = [] if layer.edges is None else list_edge_parts(layer.edges)
    return {part for part in parts if isinstance(part, str)}


def _shown_positions(mesh: Mesh, layer: Layer) -> Float64Array:
    """Return the points that `layer` shows (p, 3): those of faces and of edges that are given, or all, if with dots."""
    if layer.point_size is not None:
        return mesh.positions
    given = [] if layer.edges is None else [part for part in list_edge_parts(layer.edges) if not isinstance(part, str)]
    if not given or mesh.n_points == 0:
        return mesh.used_positions
    is_used = np.zeros(mesh.n_points, np.bool_)
    is_used[mesh.indices] = True
    for part in given:
        is_used[as_index_pairs(part, mesh.n_points)] = True
    return mesh.positions if is_used.all() or not is_used.any() else mesh.positions[is_used]


class BufferSource:
    """The geometry of a point buffer: points on the device, joined by edges that the caller gives."""

    n_faces = 0
    mesh: Mesh | None = None
    sample_edges: Callable[[], Float64Array] | None = None

    def __init__(self, points: PointBuffer, name: str) -> None:
        if points.shape[1] != 3:
            raise ArgumentError.expecting("model", "hold points of shape (n, 3)", points.shape)
        self._points = points
        self.name = name
        self.n_points = len(points)
        self.owner: object = points

    def edges(self, layer: Layer) -> EdgeSource:
        """Return `layer.edges`, an array, checked."""
        if colors_by_face(layer):
            raise ArgumentError("colours by face need a model with faces, got a PointBuffer")
        if layer.edges is None:
            return EdgeSource(lambda: np.empty((0, 2), np.int64), None, 0, None)
        parts = list_edge_parts(layer.edges)
        named = next((part for part in parts if isinstance(part, str)), None)
        if named is not None:
            raise ArgumentError(
                f"edges by name need a model with faces, got {named!r} for a PointBuffer",
                argument="edges",
                expected="be an array for a PointBuffer",
            )
        pairs = np.concatenate([as_index_pairs(part, self.n_points) for part in parts])
        if len(pairs) == 0:
            raise ArgumentError.expecting("edges", "hold at least one pair of points", "none")
        return EdgeSource(lambda: pairs, None, len(pairs), None)

    def silhouette_candidates(self, _layer: Layer) -> None:
        """Return None: there are no faces."""

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return none."""
        return np.empty((0, 3), np.int64), np.empty(0, np.int64)

    def framing_points(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the points' box, found on the device; none if a point is not finite."""
        bounds = self._bounds
        return box_in_world(bounds if np.isfinite(bounds).all() else bounds[:0], world_from_model)

    def unbounded_points(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the box of the finite points, if `framing_points` has none."""
        if np.isfinite(self._bounds).all():
            return np.empty((0, 3))
        points = self._points.numpy().astype(np.float64)
        points = points[np.isfinite(points).all(axis=1)]
        return box_in_world(points, world_from_model)

    def box_corners(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the box of the points' instances; of the finite ones, if some are not."""
        return np.concatenate([self.framing_points(world_from_model), self.unbounded_points(world_from_model)])

    @cached_property
    def _bounds(self) -> Float64Array:
        return self._points.bounds().astype(np.float64)

    def on_device(self, device: GpuDevice) -> tuple[DevicePoints, Float64Array]:
        """Return the points as they are; a pending transform goes into the matrix."""
        if self._points.device is not device:
            raise ArgumentError(f"model is on {self._points.device!r}, device is {device!r}: they must be one")
        pending = self._points.pending
        return self._points.device_points(), np.eye(4) if pending is None else pending


class MeshBufferSource(BufferSource):
    """The geometry of a mesh buffer: points on the device; edges and faces that stay there from frame to frame."""

    def __init__(self, points: MeshBuffer, name: str, layer: Layer) -> None:
        super().__init__(points, name)
        self._mesh_buffer = points
        self._topology = MeshSource(points.topology, name, layer)
        self.n_faces = points.topology.n_faces
        self.owner = points.topology

    @cached_property
    def mesh(self) -> Mesh:  # type: ignore[override]  # read when it is needed
        """The mesh where its points are."""
        return self._mesh_buffer.mesh

    def edges(self, layer: Layer) -> EdgeSource:
        """Return the edges that do not depend on where the points are."""
        return self._topology.edges(layer)

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return the polygons as triangles, as they are cut where the mesh was given."""
        return self._topology.triangles()

    def on_device(self, device: GpuDevice) -> tuple[DevicePoints, Float64Array]:
        """Return the points as they are, within their box."""
        points, model_from_points = super().on_device(device)
        if self._points.pending is None and np.isfinite(self._bounds).all():
            points = replace(points, bounding_points=box_corners(self._bounds))
        return points, model_from_points
