"""Concatenation of meshes."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..geometry.attributes import NO_ATTRIBUTES, Attributes, RaggedArray
from ..geometry.mesh import Mesh
from ..geometry.mesh_copies import place_copies
from ._warn import warn
from .limits import budget

LIBRARIES = "mtllib"  # under which OBJ keeps the names of its files of materials
_PLACES = ("point", "corner", "face")
_MAX_NAMED = 4


def concatenate_placed(placed: Iterable[tuple[Mesh, Float64Array]]) -> Mesh:
    """Return meshes as one, with a copy of each wherever one of its matrices (k, 4, 4) puts it."""
    return concatenate([place_copies(mesh, matrices) for mesh, matrices in placed])


def concatenate(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of the points and faces of all `meshes`, in their order, with their attributes.

    An attribute that some of them lack is filled up: with white for colours, -1 for labels, NaN for other floats, and
    0 for all else.
    """
    if len(meshes) == 1:
        return meshes[0]
    points_before = np.cumsum([0, *(mesh.n_points for mesh in meshes)])
    corners_before = np.cumsum([0, *(len(mesh.indices) for mesh in meshes)])
    return Mesh.from_offsets(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([[0], *(mesh.offsets[1:] + n for mesh, n in zip(meshes, corners_before, strict=False))]),
        np.concatenate([mesh.indices + n for mesh, n in zip(meshes, points_before, strict=False)]),
        attributes=_concatenate_attributes(meshes) if any(mesh.attributes for mesh in meshes) else None,
    )


def _concatenate_attributes(meshes: Sequence[Mesh]) -> Attributes:
    """Return the attributes of all meshes."""
    labels: dict[str, dict[str, int]] = {}
    material: dict[str, Any] = {}
    clashes: dict[str, None] = {}
    for mesh in meshes:
        for name, texts in mesh.attributes.labels.items():
            known = labels.setdefault(name, {})
            for text in texts:
                known.setdefault(text, len(known))
        for name, value in mesh.attributes.material.items():
            if name == LIBRARIES:
                material[name] = tuple(dict.fromkeys((*material.get(name, ()), *value)))
            elif material.setdefault(name, value) != value:
                clashes[str(name)] = None
    if clashes:
        names = ", ".join(map(repr, [*clashes][:_MAX_NAMED])) + (", ..." if len(clashes) > _MAX_NAMED else "")
        warn(f"several materials each are called {names}, of which the first is kept")
    all_attributes = _unify_places_of_colors(meshes)
    tables = []
    for what, counts in (
        ("point", [mesh.n_points for mesh in meshes]),
        ("corner", [len(mesh.indices) for mesh in meshes]),
        ("face", [mesh.n_faces for mesh in meshes]),
    ):
        parts = [_rename_labels(attributes, what, labels) for attributes in all_attributes]
        budget().take_numbers(_count_filled(parts, counts), "attributes that not all of its parts have")
        table = {}
        for name in dict.fromkeys(name for part in parts for name in part):
            columns = [part.get(name) for part in parts]
            if name.startswith("color"):
                columns = _unify_colors(columns)
            if _can_stack(columns):
                table[name] = _stack(name, columns, counts, name in labels)
            else:
                warn(f"{name} per {what} differs in shape between the parts of the file, and is left out")
        tables.append(table)
    made = Attributes(*tables, labels={name: tuple(known) for name, known in labels.items()}, material=material)
    return made or NO_ATTRIBUTES


def _count_filled(parts: Sequence[Mapping[str, Any]], counts: Sequence[int]) -> int:
    """Return how many numbers fill up the columns that some parts lack; a part without rows is work as well."""
    n_rows, total = Counter[str](), sum(counts) + len(counts)
    widths: dict[str, int] = {}
    for part, count in zip(parts, counts, strict=True):
        for name, column in part.items():
            n_rows[name] += count + 1
            widths[name] = 1 if isinstance(column, RaggedArray) else math.prod(column.shape[1:])
    return sum((total - n_rows[name]) * width for name, width in widths.items())


def _unify_places_of_colors(meshes: Sequence[Mesh]) -> list[Attributes]:
    """Return the attributes of meshes, with their colours per corner if some have them per face and others not.

    A picture takes the colours of one place: those of others would be lost.
    """
    places = {what for mesh in meshes for what in _PLACES if "color" in getattr(mesh.attributes, what)}
    if "face" not in places or len(places) == 1:
        return [mesh.attributes for mesh in meshes]
    return [_move_colors_to_corners(mesh) for mesh in meshes]


def _move_colors_to_corners(mesh: Mesh) -> Attributes:
    """Return the attributes with the colours of faces, or else of points, per corner; a cloud's stay."""
    attributes = mesh.attributes
    tables = {what: dict(getattr(attributes, what)) for what in _PLACES}
    if mesh.n_faces and "color" not in tables["corner"]:
        if "color" in tables["face"]:
            tables["corner"]["color"] = np.repeat(tables["face"].pop("color"), np.diff(mesh.offsets), axis=0)
        elif "color" in tables["point"]:
            tables["corner"]["color"] = tables["point"].pop("color")[mesh.indices]
    return Attributes(**tables, labels=attributes.labels, material=attributes.material)


def _rename_labels(attributes: Attributes, what: str, labels: Mapping[str, Mapping[str, int]]) -> dict[str, Any]:
    """Return the columns of a table, with the numbers that all meshes share for labels."""
    table = dict(getattr(attributes, what))
    for name, texts in attributes.labels.items():
        column = table.get(name)
        if isinstance(column, np.ndarray) and column.dtype.kind in "iu":
            numbers = np.array([*(labels[name][text] for text in texts), -1], np.int32)
            is_known = (column >= 0) & (column < len(texts))
            table[name] = numbers[np.where(is_known, column, -1)]
    return table


def _unify_colors(columns: Sequence[Any]) -> list[Any]:
    """Return colours of several types or widths as four floats each; those of one kind as they are."""
    kinds = {(column.shape[1:], column.dtype) for column in columns if isinstance(column, np.ndarray)}
    if len(kinds) <= 1 or any(len(shape) != 1 or shape[0] > 4 for shape, _ in kinds):
        return list(columns)
    return [_as_rgba(column) if isinstance(column, np.ndarray) else column for column in columns]


def _as_rgba(colors: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    rgba = np.ones((len(colors), 4), np.float32)
    rgba[:, : colors.shape[1]] = colors / 255 if colors.dtype == np.uint8 else colors
    return rgba


def _can_stack(columns: Sequence[Any]) -> bool:
    held = [column for column in columns if column is not None]
    if any(isinstance(column, RaggedArray) for column in held):
        return False
    kinds = {(column.shape[1:], column.dtype.kind in "SU") for column in held}
    return len(kinds) == 1


def _stack(name: str, columns: Sequence[Any], counts: Sequence[int], is_label: bool) -> Any:
    """Return columns of the same shape as one."""
    held = [column for column in columns if column is not None]
    dtype = np.result_type(*(column.dtype for column in held))
    fill: Any = "" if dtype.kind in "SU" else np.nan if dtype.kind in "fc" else 0
    if name.startswith("color"):
        fill = 255 if dtype == np.uint8 else 1
    elif is_label:
        fill = -1
    return np.concatenate(
        [
            np.full((count, *held[0].shape[1:]), fill, dtype) if column is None else column.astype(dtype, copy=False)
            for column, count in zip(columns, counts, strict=True)
        ]
    )
