"""Attributes of glTF primitives, by the names of the package and by those of the format (3.7.2.1).

| glTF                | attribute per point      |
|---------------------|--------------------------|
| NORMAL, TANGENT     | normal, tangent          |
| COLOR_0, COLOR_1    | color, color_1           |
| TEXCOORD_0, _1      | texcoord, texcoord_1     |
| _NAME               | NAME                     |
"""

import re
from collections.abc import Collection
from itertools import count, takewhile
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from ..geometry.attributes import Attributes, RaggedArray
from ..geometry.mesh import Mesh
from .gltf_accessors import Accessors, get_count

_SETS = {"COLOR": "color", "TEXCOORD": "texcoord"}
_SINGLE = {"NORMAL": "normal", "TANGENT": "tangent"}
_NUMBERED = re.compile(r"(COLOR|TEXCOORD)_(0|[1-9][0-9]*)")
_NAMES = re.compile(r"(color|texcoord)(?:_([1-9][0-9]*))?")
_WIDTHS = {"NORMAL": (3,), "TANGENT": (4,), "TEXCOORD": (2,), "COLOR": (3, 4)}
_ELSEWHERE = re.compile(r"POSITION|JOINTS_[0-9]+|WEIGHTS_[0-9]+")


def read_attributes(semantics: Any, n_points: int, accessors: Accessors) -> dict[str, npt.NDArray[Any]]:
    """Return the attributes of a primitive per point; those of another length than the positions are left out."""
    found: dict[str, npt.NDArray[Any]] = {}
    for semantic in semantics:
        if _ELSEWHERE.fullmatch(semantic):
            continue
        i = get_count(semantics, semantic)
        if accessors.count(i) == n_points:
            found[name_attribute(semantic)] = _read_column(semantic, i, accessors)
    return found


def _read_column(semantic: str, i: int, accessors: Accessors) -> npt.NDArray[Any]:
    """Return an attribute in its own type, or as float32 if its integers stand for fractions; bytes of colours stay."""
    rows = accessors.components(i)
    if (
        accessors.is_normalized(i)
        and rows.dtype.kind in "iu"
        and not (semantic.startswith("COLOR_") and rows.dtype == np.uint8)
    ):
        rows = accessors.floats(i).astype(np.float32)
    return rows[:, 0] if rows.shape[1] == 1 else rows


def name_attribute(semantic: str) -> str:
    """Return the name of an attribute for its name in a file."""
    if semantic in _SINGLE:
        return _SINGLE[semantic]
    numbered = _NUMBERED.fullmatch(semantic)
    if numbered is None:
        return semantic[1:] if semantic.startswith("_") and len(semantic) > 1 else semantic
    kind, number = numbered.groups()
    return _SETS[kind] if number == "0" else f"{_SETS[kind]}_{number}"


def name_semantics(names: Collection[str]) -> dict[str, str]:
    """Return the names of attributes in a file; a set whose number does not follow on another is one of its own."""
    semantics = {name: _name_semantic(name) for name in names}
    found = {*semantics.values()}
    defined = {*_SINGLE}.union(*(takewhile(found.__contains__, map(f"{kind}_{{}}".format, count())) for kind in _SETS))
    return {name: semantic if semantic in defined else f"_{name}" for name, semantic in semantics.items()}


def _name_semantic(name: str) -> str:
    for semantic, single in _SINGLE.items():
        if name == single:
            return semantic
    numbered = _NAMES.fullmatch(name)
    if numbered is None:
        return f"_{name}"
    kind, number = numbered.groups()
    return f"{kind.upper()}_{number or 0}"


def fit_attributes(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Return a mesh whose normals, tangents, colours and texture coordinates have the widths of 3.7.2.1; what is lost.

    Texture coordinates lose their third number, which is no loss of zeros; whatever else has another width, or a name
    twice, is left out.
    """
    tables = {"point": dict(mesh.attributes.point), "corner": dict(mesh.attributes.corner)}
    lost, is_cut = [], False
    for what, table in tables.items():
        for name, column in list(table.items()):
            widths = _WIDTHS.get(_name_semantic(name).partition("_")[0])
            if widths is None or isinstance(column, RaggedArray) or column.dtype.kind not in "iufb":
                continue
            width = prod(column.shape[1:])
            if width == 3 and widths == (2,):
                rows = column.reshape(len(column), 3)
                table[name], is_cut = rows[:, :2], True
                if np.nan_to_num(rows[:, 2]).any():
                    lost.append(f"the third number of {name} per {what}")
            elif width not in widths:
                del table[name]
                lost.append(
                    f"{name} per {what} ({width} number{'s' * (width != 1)}, not {' or '.join(map(str, widths))})"
                )
    point, corner = tables["point"], tables["corner"]
    for name in [name for name in point if mesh.n_faces and isinstance(corner.get(name), np.ndarray)]:
        del point[name]
        lost.append(f"{name} per point (beside that per corner)")
    if not (lost or is_cut):
        return mesh, lost
    attributes = mesh.attributes
    fitted = Attributes(**tables, face=attributes.face, labels=attributes.labels, material=attributes.material)
    return mesh.with_attributes(fitted), lost
