"""Attributes of glTF primitives, by the names of the package and by those of the format (3.7.2.1).

| glTF                | attribute per point      |
|---------------------|--------------------------|
| NORMAL, TANGENT     | normal, tangent          |
| COLOR_0, COLOR_1    | color, color_1           |
| TEXCOORD_0, _1      | texcoord, texcoord_1     |
| _NAME               | NAME                     |
"""

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from .gltf_accessors import Accessors, get_count

_SETS = {"COLOR": "color", "TEXCOORD": "texcoord"}
_SINGLE = {"NORMAL": "normal", "TANGENT": "tangent"}
_NUMBERED = re.compile(r"(COLOR|TEXCOORD)_(0|[1-9][0-9]*)")
_NAMES = re.compile(r"(color|texcoord)(?:_([1-9][0-9]*))?")
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


def name_semantic(name: str) -> str:
    """Return the name of an attribute in a file."""
    for semantic, single in _SINGLE.items():
        if name == single:
            return semantic
    numbered = _NAMES.fullmatch(name)
    if numbered is None:
        return f"_{name}"
    kind, number = numbered.groups()
    return f"{kind.upper()}_{number or 0}"
