"""Shading: faces as bright as a lamp at the eye makes them, by Lambert's law."""

import weakref
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..geometry.corner_normals import find_corner_normals
from ..geometry.edges import compute_plane_normals, find_edge_faces
from ..geometry.mesh import Mesh
from .depth import eye

AMBIENT = 0.3  # of a face's colour, that one seen edge-on keeps

_normals: dict[int, tuple["weakref.ref[Mesh]", Float64Array]] = {}  # of faces, by the id of a mesh that lives


def shade_faces(
    colors: Float64Array, mesh: Mesh, world_from_model: Float64Array, clip_from_world: Float64Array
) -> Float64Array:
    """Return the colours of faces in the light of a lamp far behind the eye: (f, 4).

    colors : (f, 4) or (1, 4), straight alpha, which stays
    world_from_model : (4, 4)
    clip_from_world : (4, 4), reversed-Z

    Colour = colour · (a + (1 - a) |n · l|), with `AMBIENT` a, the unit normal n of the face and the unit vector l
    against the camera's direction of view, both in the world: Lambert, "Photometria", 1760. Both sides of a face are
    lit, since files wind their faces either way.
    """
    lit = lit_share(np.abs(_cosines(mesh, world_from_model, _towards_eye(clip_from_world))))
    shaded = np.empty((mesh.n_faces, 4))
    shaded[:, :3] = colors[:, :3] * lit[:, np.newaxis]
    shaded[:, 3] = colors[:, 3]
    return shaded


def _cosines(mesh: Mesh, world_from_model: Float64Array, towards_eye: Float64Array) -> Float64Array:
    """Return n · l for each face (f,), 0 for one without a normal."""
    normals = _face_normals(mesh) @ _cofactors(world_from_model)
    lengths = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    result: Float64Array = normals @ towards_eye / np.where(lengths > 0.0, lengths, 1.0)
    return result


def lit_share(light: Float64Array) -> Float64Array:
    """Return what is left of a colour where `light` is |n · l|."""
    return AMBIENT + (1.0 - AMBIENT) * light


def light_from_normals(world_from_model: Float64Array, clip_from_world: Float64Array) -> Float64Array:
    """Return the matrix (3, 3) from normals of a model to a frame whose third axis is l of `shade_faces`."""
    towards_eye = _towards_eye(clip_from_world)
    aside = np.cross(towards_eye, np.eye(3)[np.abs(towards_eye).argmin()])
    aside /= np.linalg.norm(aside) or 1.0
    matrix: Float64Array = np.stack([aside, np.cross(towards_eye, aside), towards_eye]) @ _cofactors(world_from_model).T
    return matrix / (np.abs(matrix).max() or 1.0)


def triangle_normals(mesh: Mesh, triangles: IndexArray, faces: IndexArray, crease_angle: float) -> Float64Array:
    """Return the unit normals at the corners of triangles: (t, 3, 3), as `find_corner_normals` has them.

    triangles : (t, 3) points, of the mesh's faces (t,)
    """
    normals = find_corner_normals(mesh, crease_angle)
    if len(mesh.indices) == triangles.size:  # all faces are triangles
        return normals.reshape(-1, 3, 3)
    sizes = np.diff(mesh.offsets)
    keys = np.repeat(np.arange(mesh.n_faces), sizes) * mesh.n_points + mesh.indices
    order = np.argsort(keys, kind="stable")
    corners = order[np.searchsorted(keys[order], faces[:, np.newaxis] * mesh.n_points + triangles)]
    at_corners: Float64Array = normals[corners]
    return at_corners


def pack_normals(normals: Float64Array) -> npt.NDArray[np.uint32]:
    """Return unit vectors (..., 3) as numbers (...,) of 32 bits, which wgsl/shared/octahedral.wgsl unpacks."""
    with np.errstate(invalid="ignore"):
        x, y, z = np.moveaxis(normals / np.abs(normals).sum(axis=-1, keepdims=True), -1, 0)
    fold = np.maximum(-z, 0.0)
    square: npt.NDArray[Any] = np.stack([x + np.where(x >= 0.0, fold, -fold), y + np.where(y >= 0.0, fold, -fold)], -1)
    halves = np.rint(np.nan_to_num(square) * 32767.0).astype(np.int16)
    packed: npt.NDArray[np.uint32] = halves.view(np.uint32)[..., 0]
    return packed


def _cofactors(world_from_model: Float64Array) -> Float64Array:
    """Return the matrix (3, 3) that rows of normals are multiplied by to take them to the world.

    Normals go there by the inverse transpose, of which the cofactors are a multiple; they exist for a matrix that
    flattens the model too.
    """
    columns = world_from_model[:3, :3].T
    return np.stack([np.cross(columns[1], columns[2]), np.cross(columns[2], columns[0]), np.cross(*columns[:2])])


def _face_normals(mesh: Mesh) -> Float64Array:
    """Return the unit normals of the faces (f, 3), which are kept for the next picture."""
    key = id(mesh)
    kept = _normals.get(key)
    if kept is not None and kept[0]() is mesh:
        return kept[1]
    normals = compute_plane_normals(mesh, lambda: find_edge_faces(mesh))
    _normals[key] = weakref.ref(mesh, lambda _: _normals.pop(key, None)), normals
    return normals


def _towards_eye(clip_from_world: Float64Array) -> Float64Array:
    """Return the unit vector of the world against the camera's direction of view."""
    place = eye(clip_from_world)
    direction = -clip_from_world[3, :3] if clip_from_world[3, :3].any() else place[:3]
    result: Float64Array = direction / (np.linalg.norm(direction) or 1.0)
    return result
