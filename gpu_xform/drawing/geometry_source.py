"""What the model of a layer holds: points, edges, faces, and how they get onto a device."""

import itertools
import os
from collections.abc import Callable, Hashable, Sequence
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError
from ..geometry.edges import (
    edge_faces,
    edge_parts,
    index_pairs,
    is_one_array,
    may_show,
    plane_normals,
    resolve_edges,
    without_silhouette,
)
from ..geometry.mesh import Mesh, pair_keys
from ..geometry.triangulation import triangulate
from ..gpu.chunking import align_points
from ..gpu.device import Device
from ..gpu.device_points import DevicePoints
from ..gpu.layouts import CANDIDATE
from .layer import Layer
from .layer_colors import by_face

NO_FACE = 2**32 - 1
MAX_BOUNDING_POINTS = 1 << 10  # points; of larger models the corners of their box do


class Pairs(NamedTuple):
    """Points that are joined, found when they are asked for, because a device may have them already.

    find : gives (m, 2)
    rows : gives which row of colours belongs to each of what was found, (m,); None where they are in order
    n_rows : of colours
    role : under which a device keeps what was found; None for what is given for one picture
    """

    find: Callable[[], IndexArray]
    rows: Callable[[IndexArray], IndexArray] | None
    n_rows: int
    role: Hashable | None


class Candidates(NamedTuple):
    """What a view finds its silhouette among: `layouts.CANDIDATE` (m,), and the planes of the faces (f, 4) float32."""

    find: Callable[[], npt.NDArray[np.void]]
    planes: Callable[[], npt.NDArray[np.float32]]
    rows: Callable[[IndexArray], IndexArray]
    role: Hashable | None


class Subject(Protocol):
    """Points in a model's frame, and which of them are joined."""

    @property
    def name(self) -> str:
        """What the model is called; may be empty."""
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
        """What the arrays that a device keeps belong to."""
        ...

    def pairs(self, layer: Layer) -> Pairs:
        """Return the edges that `layer` draws in every view."""
        ...

    def candidates(self, layer: Layer) -> Candidates | None:
        """Return what the silhouette is found among, where `layer` draws one."""
        ...

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return the faces as triangles (t, 3), and the face of each (t,)."""
        ...

    @property
    def mesh(self) -> Mesh | None:
        """The mesh, where there are faces."""
        ...

    def outline(self, world_from_model: Float64Array) -> Float64Array:
        """Return points of the world (p, 3) that a camera must hold to hold all instances."""
        ...

    def on_device(self, device: Device) -> tuple[DevicePoints, Float64Array]:
        """Return the points on `device`, and the (4, 4) matrix from them to the model's frame."""
        ...


def subject(layer: Layer) -> Subject:
    """Return what the model of `layer` holds; a path is loaded."""
    model = layer.model
    if isinstance(model, PointBuffer):
        return BufferSubject(model, layer.name or "")
    if isinstance(model, Mesh):
        return MeshSubject(model, layer.name or "")
    from ..formats import load_mesh

    path: str | os.PathLike[str] = model  # type: ignore[assignment]  # of an array, the layer has made a Mesh
    return MeshSubject(load_mesh(path), Path(path).stem if layer.name is None else layer.name)


class MeshSubject:
    """A mesh in the host's memory."""

    def __init__(self, mesh: Mesh, name: str) -> None:
        self.mesh = mesh
        self.name = name
        self.n_points = mesh.n_points
        self.n_faces = mesh.n_faces
        self.owner: object = mesh

    def pairs(self, layer: Layer) -> Pairs:
        """Return the mesh's own edges where `layer.edges` is None, in the order of the faces for colours by face."""
        mesh, edges, angle = self.mesh, layer.edges, layer.feature_angle
        if by_face(layer):
            if edges is not None and any(not isinstance(part, str) or part != "all" for part in edge_parts(edges)):
                raise ArgumentError(f"edges must be 'all' where each face has its own colour, got {edges!r}")
            # What faces share has the colour of the last: drawn for each, its rim would be of both, and heavier.
            return Pairs(
                lambda: mesh.face_edges[mesh.last_face_edges],
                lambda _: mesh.face_edge_faces[mesh.last_face_edges],
                mesh.n_faces,
                "outlines",
            )
        if edges is None:
            return Pairs(lambda: mesh.edges, None, len(mesh.edges), "edges")
        rest, _ = without_silhouette(edges)
        if rest is None:
            return Pairs(lambda: np.empty((0, 2), np.int64), None, len(mesh.edges), "no edges")

        def find() -> IndexArray:
            return resolve_edges(mesh, rest, angle)

        if isinstance(rest, str):
            return Pairs(find, self._rows, len(mesh.edges), ("edges", rest, angle))
        if is_one_array(edges):
            return Pairs(find, None, len(find()), None)
        return Pairs(find, self._rows, len(mesh.edges), None)

    def candidates(self, layer: Layer) -> Candidates | None:
        """Return the edges that are not drawn in every view, of which `find_silhouette` chooses."""
        if layer.edges is None or by_face(layer):
            return None
        rest, has_silhouette = without_silhouette(layer.edges)
        if not has_silhouette:
            return None
        mesh, angle = self.mesh, layer.feature_angle

        def find() -> npt.NDArray[np.void]:
            found = edge_faces(mesh)
            left = may_show(mesh, found)
            if rest is not None:
                drawn = resolve_edges(mesh, rest, angle)
                left = ~np.isin(pair_keys(*found.edges.T), pair_keys(*drawn.T))
            candidates = np.zeros(int(left.sum()), CANDIDATE)
            candidates["edge"] = found.edges[left]
            between_two = (found.n_faces == 2) & ~found.segments
            candidates["faces"] = np.where(between_two[:, None], found.faces, NO_FACE)[left]
            candidates["is_turned"] = found.turned[left]
            return candidates

        role = ("silhouette", rest, angle) if rest is None or isinstance(rest, str) else None
        return Candidates(find, self._planes, self._rows, role)

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return the polygons as triangles."""
        return triangulate(self.mesh.positions, self.mesh.offsets, self.mesh.indices)

    def outline(self, world_from_model: Float64Array) -> Float64Array:
        """Return all points that lie before the eye; of more than one instance, the corners of their boxes."""
        positions = self.mesh.positions
        if len(world_from_model) > 1 and self.n_points > 8:
            positions = box_corners(self.mesh.bounds)
        return np.concatenate([world_positions(positions, matrix) for matrix in world_from_model])

    def on_device(self, device: Device) -> tuple[DevicePoints, Float64Array]:
        """Return the points in single precision, moved and scaled into [-1, 1]^3.

        Single precision would lose the shape of a small model far from the origin, and has no room for very large ones.
        """
        center, half_size = self._unit_cube()
        model_from_unit = np.diag([half_size, half_size, half_size, 1.0])
        model_from_unit[:3, 3] = center

        def padded() -> npt.NDArray[np.float32]:
            points = np.zeros((align_points(self.n_points), 3), np.float32)
            points[: self.n_points] = self._in_unit_cube()
            return points

        buffer = device.resource_cache.get(self.owner, "points", padded)
        bounding_points = self.mesh.positions if self.n_points <= MAX_BOUNDING_POINTS else box_corners(self.mesh.bounds)
        return DevicePoints(
            buffer, self.n_points, np.dtype(np.float32), (bounding_points - center) / half_size
        ), model_from_unit

    def _unit_cube(self) -> tuple[Float64Array, float]:
        return self.mesh.center, float((self.mesh.bounds[1] - self.mesh.center).max()) or 1.0

    def _in_unit_cube(self) -> Float64Array:
        center, half_size = self._unit_cube()
        scaled: Float64Array = (self.mesh.positions - center) / half_size
        return scaled

    def _planes(self) -> npt.NDArray[np.float32]:
        """Return the normal and the offset of each face, in the frame of the points on a device."""
        normals = plane_normals(self.mesh, lambda: edge_faces(self.mesh))
        a_corner = self.mesh.indices[self.mesh.offsets[:-1]]
        offsets = -np.einsum("ij,ij->i", normals, self._in_unit_cube()[a_corner])
        return np.column_stack([normals, offsets]).astype(np.float32)

    def _rows(self, pairs: IndexArray) -> IndexArray:
        """Return where in `mesh.edges` each of `pairs` is."""
        known, keys = pair_keys(*self.mesh.edges.T), pair_keys(*pairs.T)
        rows = np.searchsorted(known, keys)
        strange = np.flatnonzero(~np.isin(keys, known))
        if len(strange):
            pair = tuple(pairs[strange[0]].tolist())
            raise ArgumentError(
                f"edge_colors can go with one array of edges, or with edges of the model, which {pair} is not"
            )
        return rows


class BufferSubject:
    """Points on the device, joined by edges that the caller knows."""

    n_faces = 0
    mesh: Mesh | None = None

    def __init__(self, points: PointBuffer, name: str) -> None:
        if points.shape[1] != 3:
            raise ArgumentError(f"model must hold points of shape (n, 3), got {points.shape}")
        self._points = points
        self.name = name
        self.n_points = len(points)
        self.owner: object = points

    def pairs(self, layer: Layer) -> Pairs:
        """Return `layer.edges`, an array, checked."""
        if by_face(layer):
            raise ArgumentError("colours by face need a model with faces, got a PointBuffer")
        if layer.edges is None:
            return Pairs(lambda: np.empty((0, 2), np.int64), None, 0, None)
        parts = edge_parts(layer.edges)
        named = next((part for part in parts if isinstance(part, str)), None)
        if named is not None:
            raise ArgumentError(f"edges by name need a model with faces, got {named!r} for a PointBuffer")
        pairs = np.concatenate([index_pairs(part, self.n_points) for part in parts])
        if len(pairs) == 0:
            raise ArgumentError("edges must hold at least one pair of points, got none")
        return Pairs(lambda: pairs, None, len(pairs), None)

    def candidates(self, _layer: Layer) -> None:
        """Return None: there are no faces."""

    def triangles(self) -> tuple[IndexArray, IndexArray]:
        """Return none."""
        return np.empty((0, 3), np.int64), np.empty(0, np.int64)

    def outline(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the points' box, found on the device; none where a point is not finite."""
        bounds = self._bounds
        return _box_in_world(bounds if np.isfinite(bounds).all() else bounds[:0], world_from_model)

    def strays(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the box of the finite points, which are drawn, where `outline` has none."""
        if np.isfinite(self._bounds).all():
            return np.empty((0, 3))
        points = self._points.numpy().astype(np.float64)
        points = points[np.isfinite(points).all(axis=1)]
        return _box_in_world(points, world_from_model)

    @cached_property
    def _bounds(self) -> Float64Array:
        return self._points.bounds().astype(np.float64)

    def on_device(self, device: Device) -> tuple[DevicePoints, Float64Array]:
        """Return the points as they are; what is pending goes into the matrix."""
        if self._points.device is not device:
            raise ArgumentError(f"model is on {self._points.device!r}, device is {device!r}: they must be one")
        pending = self._points.pending
        return self._points.device_points(), np.eye(4) if pending is None else pending


def outline(layers: Sequence[Layer], subjects: Sequence[Subject]) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold."""
    parts = [model.outline(layer.world_from_model) for layer, model in zip(layers, subjects, strict=True)]
    return np.concatenate(parts)


def strays(layers: Sequence[Layer], subjects: Sequence[Subject]) -> Float64Array:
    """Return points of the world (k, 3) that hold what is drawn beside `outline`."""
    found = [
        model.strays(layer.world_from_model)
        for layer, model in zip(layers, subjects, strict=True)
        if isinstance(model, BufferSubject)
    ]
    return np.concatenate([np.empty((0, 3)), *found])


def box_corners(bounds: Float64Array) -> Float64Array:
    """Return the corners (8, 3) of the box from `bounds` (2, 3)."""
    return np.array(list(itertools.product(*bounds.T)))


def _box_in_world(points: Float64Array, world_from_model: Float64Array) -> Float64Array:
    """Return the corners of the box around `points` (n, 3) in each of the instances (k, 4, 4)."""
    if len(points) == 0:
        return np.empty((0, 3))
    corners = box_corners(np.stack([points.min(axis=0), points.max(axis=0)]))
    return np.concatenate([world_positions(corners, matrix) for matrix in world_from_model])


def world_positions(positions: Float64Array, world_from_model: Float64Array) -> Float64Array:
    """Return `positions` (n, 3) in the world, divided by w; what has w <= 0 is left out."""
    with np.errstate(over="ignore", invalid="ignore"):
        homogeneous = positions @ world_from_model[:, :3].T + world_from_model[:, 3]
    in_front = homogeneous[homogeneous[:, 3] > 0.0]
    return np.asarray(in_front[:, :3] / in_front[:, 3:])
