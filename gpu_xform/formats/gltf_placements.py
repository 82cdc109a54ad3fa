"""Names and matrices of the nodes of a glTF document. Section numbers are those of the glTF 2.0 specification."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .._core.arguments import as_unit_vector, as_vector, require_affine
from .._core.types import Float64Array
from ..errors import MeshError
from ..geometry.scene_animation import Placement, compose_placement
from ._text import quote

# Matrices are often products in float32: what their last row may miss (0, 0, 0, 1) by.
_LAST_ROW_TOLERANCE = 1e-6


def make_names(given: Sequence[Any], noun: str) -> list[str]:
    """Return a name for each item that no other has.

    The first of a name keeps it; the others become "wheel 2", "wheel 3", ... as far as those are free. Node 7 without
    a name becomes "node 7".
    """
    taken, used = {name for name in given if isinstance(name, str)}, set[str]()
    variants: dict[str, Iterator[str]] = {}
    names: list[str] = []
    for i, name in enumerate(given):
        if name is not None and not isinstance(name, str):
            raise MeshError(f"{noun} {i}: name must be a text, got {quote(repr(name))}")
        if not name or name in used:
            stem = name or f"{noun} {i}"
            name = next(new for new in variants.setdefault(stem, _variants(stem)) if new not in taken)
        taken.add(name)
        used.add(name)
        names.append(name)
    return names


def _variants(stem: str) -> Iterator[str]:
    yield stem
    yield from (f"{stem} {number}" for number in itertools.count(2))


_PLACING = frozenset({"matrix", "rotation", "scale", "translation"})


def local_matrix(node: Any) -> Float64Array:
    """Return the matrix of a node, given as such or as T R S (3.5.3)."""
    if not _PLACING & node.keys():
        return np.eye(4)
    if "matrix" not in node:
        placement = read_placement(node)
        return compose_placement(placement.translation, placement.rotation, placement.scale)
    if "translation" in node or "rotation" in node or "scale" in node:
        raise MeshError("it has both a matrix and a translation, rotation or scale")
    matrix = as_vector(node["matrix"], "matrix", 16).reshape(4, 4).T.copy()
    last_row = np.eye(4)[3]
    if np.abs(matrix[3] - last_row).max() <= _LAST_ROW_TOLERANCE:
        matrix[3] = last_row
    require_affine(matrix, "matrix")
    return matrix


def read_placement(node: Any) -> Placement:
    """Return the translation, the rotation and the scale of a node that has no matrix."""
    return Placement(
        as_vector(node["translation"], "translation", 3) if "translation" in node else np.zeros(3),
        as_unit_vector(node["rotation"], "rotation", 4) if "rotation" in node else np.array([0.0, 0.0, 0.0, 1.0]),
        as_vector(node["scale"], "scale", 3) if "scale" in node else np.ones(3),
    )
