"""Shading: faces as bright as a lamp at the eye makes them, by Lambert's law."""

import weakref

import numpy as np

from .._core.types import Float64Array
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
    lit = AMBIENT + (1.0 - AMBIENT) * np.abs(_cosines(mesh, world_from_model, _towards_eye(clip_from_world)))
    shaded = np.empty((mesh.n_faces, 4))
    shaded[:, :3] = colors[:, :3] * lit[:, np.newaxis]
    shaded[:, 3] = colors[:, 3]
    return shaded


def _cosines(mesh: Mesh, world_from_model: Float64Array, towards_eye: Float64Array) -> Float64Array:
    """Return n · l for each face (f,), 0 for one without a normal."""
    # Normals go to the world by the inverse transpose, of which the cofactors are a multiple; they exist for a matrix
    # that flattens the model too.
    columns = world_from_model[:3, :3].T
    cofactors = np.stack([np.cross(columns[1], columns[2]), np.cross(columns[2], columns[0]), np.cross(*columns[:2])])
    normals = _face_normals(mesh) @ cofactors
    lengths = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    result: Float64Array = normals @ towards_eye / np.where(lengths > 0.0, lengths, 1.0)
    return result


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
