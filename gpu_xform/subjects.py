"""What a picture shows: the edges of a mesh, or edges between points that are on the device already."""

import contextlib
import itertools
import os
from collections.abc import Iterator
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ._arguments import Float64Array
from .colors import FACE_CYCLE, ColorLike, packed, rgba
from .edge_sets import EdgesLike, index_pairs, resolve_edges
from .errors import ArgumentError, ArgumentTypeError, MeshError
from .gpu.buffers import Buffer
from .gpu.device import Device
from .gpu.line_pass import Points
from .gpu.plans import rounded_up
from .mesh import Mesh
from .point_buffer import PointBuffer

Model = Mesh | PointBuffer | str | os.PathLike[str]
Edges = npt.NDArray[np.uint32]


class Subject(Protocol):
    """Points in a model's frame, and which of them are joined."""

    @property
    def n_points(self) -> int:
        """The number of points."""
        ...

    def lines(
        self, edges: EdgesLike | None, feature_angle: float, color: ColorLike
    ) -> tuple[Edges, npt.NDArray[np.uint32]]:
        """Return the edges to draw (m, 2) in their order, and their packed colours (1,) or (m,)."""
        ...

    def outline(self, world_from_model: Float64Array) -> Float64Array:
        """Return points of the world (k, 3) that a camera must hold to hold the subject."""
        ...

    def on_device(self, device: Device) -> contextlib.AbstractContextManager[tuple[Points, Float64Array]]:
        """Lend the points on `device`, and the (4, 4) matrix from them to the model's frame."""
        ...


def subject(model: Model) -> Subject:
    """Return what `model` shows; a path is loaded."""
    if isinstance(model, str | os.PathLike):
        from .formats import load_mesh

        return MeshSubject(load_mesh(model))
    if isinstance(model, Mesh):
        return MeshSubject(model)
    if isinstance(model, PointBuffer):
        return BufferSubject(model)
    raise ArgumentTypeError(f"model must be a Mesh, a PointBuffer or a path, got {type(model).__name__}")


class MeshSubject:
    """A mesh in the host's memory."""

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh

    @property
    def n_points(self) -> int:
        """The number of points."""
        return self._mesh.n_points

    def lines(
        self, edges: EdgesLike | None, feature_angle: float, color: ColorLike
    ) -> tuple[Edges, npt.NDArray[np.uint32]]:
        """Return the mesh's own edges where `edges` is None; for the colour "face", every face's outline."""
        mesh = self._mesh
        by_face = isinstance(color, str) and color == "face"
        if edges is not None:
            if by_face:
                raise ArgumentError("color 'face' draws the outlines of faces: it cannot go with edges of one's own")
            chosen = resolve_edges(mesh, edges, feature_angle)
            if len(chosen) == 0:
                raise MeshError(f"edges must choose at least one edge, {edges!r} chooses none of {len(mesh.edges)}")
            return chosen.astype(np.uint32), packed([rgba(color, "color")])
        if len(mesh.face_edges) == 0:
            raise MeshError(f"model must have edges to draw, got {mesh.n_points} points and {mesh.n_faces} faces")
        if len(mesh.edges) == 0:
            raise MeshError("model must have edges to draw, got only edges from a point to itself")
        if by_face:
            cycle = packed([rgba(name, "color") for name in FACE_CYCLE])
            return mesh.face_edges.astype(np.uint32), cycle[mesh.face_edge_faces % len(cycle)]
        return mesh.edges.astype(np.uint32), packed([rgba(color, "color")])

    def outline(self, world_from_model: Float64Array) -> Float64Array:
        """Return all points that lie before the eye."""
        return world_positions(self._mesh.positions, world_from_model)

    @contextlib.contextmanager
    def on_device(self, device: Device) -> Iterator[tuple[Points, Float64Array]]:
        """Upload the points, in single precision, for the time of the block."""
        positions, model_from_unit = in_unit_cube(self._mesh)
        buffer = Buffer(device, rounded_up(len(positions)) * 12)
        try:
            buffer.upload(positions)
            yield Points(buffer, len(positions), positions.dtype), model_from_unit
        finally:
            buffer.release()


class BufferSubject:
    """Points on the device, joined by edges that the caller knows."""

    def __init__(self, points: PointBuffer) -> None:
        if points.shape[1] != 3:
            raise ArgumentError(f"model must hold points of shape (n, 3), got {points.shape}")
        self._points = points

    @property
    def n_points(self) -> int:
        """The number of points."""
        return len(self._points)

    def lines(
        self, edges: EdgesLike | None, _feature_angle: float, color: ColorLike
    ) -> tuple[Edges, npt.NDArray[np.uint32]]:
        """Return `edges`, an array, checked, in one colour."""
        if edges is None:
            raise ArgumentError("edges must say which points of a PointBuffer are joined, got None")
        if isinstance(color, str) and color == "face":
            raise ArgumentError("color 'face' needs a model with faces, got a PointBuffer")
        if isinstance(edges, str):
            raise ArgumentError(f"edges by name need a model with faces, got {edges!r} for a PointBuffer")
        pairs = index_pairs(edges, self.n_points)
        if len(pairs) == 0:
            raise ArgumentError("edges must hold at least one pair of points, got none")
        return pairs.astype(np.uint32), packed([rgba(color, "color")])

    def outline(self, world_from_model: Float64Array) -> Float64Array:
        """Return the corners of the points' box, found on the device."""
        bounds = self._points.bounds().astype(np.float64)
        corners = np.array(list(itertools.product(*bounds.T)))
        return world_positions(corners, world_from_model)

    @contextlib.contextmanager
    def on_device(self, device: Device) -> Iterator[tuple[Points, Float64Array]]:
        """Lend the points as they are; what is pending goes into the matrix."""
        if self._points.device is not device:
            raise ArgumentError(f"model is on {self._points.device!r}, device is {device!r}: they must be one")
        pending = self._points.pending
        yield self._points.resident(), np.eye(4) if pending is None else pending


def in_unit_cube(mesh: Mesh) -> tuple[npt.NDArray[np.float32], Float64Array]:
    """Return the points of `mesh` moved and scaled into [-1, 1]^3, and the (4, 4) matrix that puts them back.

    Single precision would lose the shape of a small model far from the origin, and has no room for very large ones.
    """
    half_size = float((mesh.bounds[1] - mesh.center).max()) or 1.0
    model_from_unit = np.diag([half_size, half_size, half_size, 1.0])
    model_from_unit[:3, 3] = mesh.center
    return ((mesh.positions - mesh.center) / half_size).astype(np.float32), model_from_unit


def world_positions(positions: Float64Array, world_from_model: Float64Array) -> Float64Array:
    """Return `positions` (n, 3) in the world, divided by w; what has w <= 0 is left out."""
    homogeneous = positions @ world_from_model[:, :3].T + world_from_model[:, 3]
    in_front = homogeneous[homogeneous[:, 3] > 0.0]
    return np.asarray(in_front[:, :3] / in_front[:, 3:])
