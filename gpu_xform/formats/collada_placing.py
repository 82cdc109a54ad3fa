"""Parts of COLLADA files at all their places, as one mesh: each part is moved to all of them at once."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..geometry.attributes import are_mirroring
from ..geometry.mesh import Mesh
from .collada_geometries import Triangles

Color = npt.NDArray[np.uint8] | None
Part = tuple[Triangles, Color]  # with the colour of its material


@dataclass(frozen=True)
class _Blocks:
    """The places of parts, in order: which part is there, where its points and faces begin, and its matrix."""

    parts: IndexArray
    n_faces: IndexArray
    first_points: IndexArray
    first_faces: IndexArray
    matrices: IndexArray
    triangles: list[tuple[Triangles, IndexArray]]  # with the places of each, in whatever colour


def place_parts(
    shapes: list[list[Part]], shape_numbers: IndexArray, matrices: Float64Array, matrix_numbers: IndexArray
) -> Mesh:
    """Return the parts of shapes as one mesh.

    shapes : the parts of each
    shape_numbers, matrix_numbers : for each place, the shape that is there, and its matrix
    matrices : (n, 4, 4), affine
    Raises MeshError if a coordinate overflows.
    """
    parts = [part for shape in shapes for part in shape]
    unique = {id(part): part for part, _ in parts}  # they often differ only in their colours
    numbers_of = {key: number for number, key in enumerate(unique)}
    of_parts = np.array([numbers_of[id(part)] for part, _ in parts], np.int64)
    counts = np.array([len(shape) for shape in shapes], np.int64)
    shown = _list_ranges((np.cumsum(counts) - counts)[shape_numbers], counts[shape_numbers])
    shown_triangles = of_parts[shown]
    n_points = np.array([len(part.positions) for part in unique.values()], np.int64)[shown_triangles]
    n_faces = np.array([len(part.corners) for part in unique.values()], np.int64)[shown_triangles]
    order = np.argsort(shown_triangles, kind="stable")
    ends = np.cumsum(np.bincount(shown_triangles, minlength=len(unique)))
    blocks = _Blocks(
        shown,
        n_faces,
        np.cumsum(n_points) - n_points,
        np.cumsum(n_faces) - n_faces,
        np.repeat(matrix_numbers, counts[shape_numbers]),
        list(zip(unique.values(), np.split(order, ends[:-1]), strict=True)),
    )
    is_mirrored = are_mirroring(matrices)
    positions = np.empty((int(n_points.sum()), 3))
    corners = np.empty((int(n_faces.sum()), 3), np.int64)
    for part, places in blocks.triangles:
        numbers, first_points = blocks.matrices[places], blocks.first_points[places, None]
        with np.errstate(over="ignore", invalid="ignore"):
            moved = part.positions @ matrices[numbers, :3, :3].transpose(0, 2, 1)
            moved += matrices[numbers, None, :3, 3]
        positions[first_points + np.arange(len(part.positions))] = moved
        turned = np.where(is_mirrored[numbers, None, None], part.corners[:, [0, 2, 1]], part.corners)
        corners[blocks.first_faces[places, None] + np.arange(len(part.corners))] = turned + first_points[:, :, None]
    return Mesh(positions, corners, attributes=_join_colors(parts, blocks, corners, len(positions)))


def _join_colors(
    parts: list[Part], blocks: _Blocks, corners: IndexArray, n_points: int
) -> dict[str, dict[str, npt.NDArray[np.uint8]]]:
    """Return the colours of materials per face, those of points per point, and both, if there are both, per corner.

    What has none is white.
    """
    is_of_material = np.array([color is not None for _, color in parts])
    has_points = any(color is None and part.colors is not None for part, color in parts)
    tables: dict[str, npt.NDArray[np.uint8]] = {}
    if is_of_material.any():
        white = np.full(4, 255, np.uint8)
        colors = np.array([white if color is None else color for _, color in parts])
        tables["face"] = np.repeat(colors[blocks.parts], blocks.n_faces, axis=0)
    if has_points:
        tables["point"] = np.full((n_points, 4), 255, np.uint8)
        for part, places in blocks.triangles:
            if part.colors is not None:
                own = places[~is_of_material[blocks.parts[places]]]
                tables["point"][blocks.first_points[own, None] + np.arange(len(part.positions))] = part.colors
    if len(tables) == 2:
        chosen = np.repeat(is_of_material[blocks.parts], blocks.n_faces)[:, None, None]
        colors = np.where(chosen, tables["face"][:, None], tables["point"][corners])
        tables = {"corner": colors.reshape(-1, 4)}
    return {what: {"color": colors} for what, colors in tables.items()}


def _list_ranges(starts: IndexArray, counts: IndexArray) -> IndexArray:
    """Return the numbers start, start + 1, ... of each range, one range after another."""
    numbers: IndexArray = np.arange(int(counts.sum())) + np.repeat(starts - (np.cumsum(counts) - counts), counts)
    return numbers
