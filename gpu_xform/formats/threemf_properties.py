"""Colours, materials and texture coordinates of 3MF, by its core specification 1.3 (5) and its extension for materials.

A triangle names a group of properties and three of its members; an object names what its triangles have by default.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..geometry.attributes import Attributes
from .limits import budget

_COLOR = re.compile(r"#([0-9a-fA-F]{6})([0-9a-fA-F]{2})?")

MEMBERS = {
    "basematerials": ("displaycolor", "name"),
    "colorgroup": ("color",),
    "compositematerials": ("values",),
    "multiproperties": ("pindices",),
    "texture2dgroup": ("u", "v"),
}
"""What is read of the members of a group, by its kind."""


@dataclass(frozen=True)
class Group:
    """A group of properties; what its kind does not have is None or empty."""

    colors: npt.NDArray[np.uint8] | None = None
    """(n, 4), red, green, blue and opacity."""
    names: tuple[str, ...] = ()
    texcoords: Float64Array | None = None
    """(n, 2)"""


_NO_GROUP = Group()


def read_group(
    kind: str, attributes: Mapping[str, str], members: Sequence[tuple[str | None, ...]], known: dict[str, Group]
) -> Group:
    """Return a group, which may refer to `known` ones; members that are malformed are white, or at (0, 0).

    members : what each says, as `MEMBERS` lists it
    """
    if kind == "basematerials":
        colors = [_parse_color(color) for color, _ in members]
        return Group(np.array(colors, np.uint8).reshape(-1, 4), tuple(name or "" for _, name in members))
    if kind == "colorgroup":
        return Group(np.array([_parse_color(color) for (color,) in members], np.uint8).reshape(-1, 4))
    if kind == "texture2dgroup":
        rows = [[*_parse_floats(f"{u} {v}"), 0.0, 0.0][:2] for u, v in members]
        return Group(texcoords=np.array(rows).reshape(-1, 2))
    rows = [_parse_floats(text) for (text,) in members]
    if kind == "compositematerials":
        base = known.get(attributes.get("matid", ""), _NO_GROUP)
        return Group(_mix(base, [int(number) for number in _parse_floats(attributes.get("matindices"))], rows))
    pids = attributes.get("pids", "")
    budget().take_elements(0, len(pids) // 2)
    return _combine([known.get(pid, _NO_GROUP) for pid in pids.split()], rows)


def _mix(base: Group, chosen: Sequence[int], parts: Sequence[Sequence[float]]) -> npt.NDArray[np.uint8] | None:
    """Return the means of base materials, weighted by their parts."""
    if base.colors is None or not parts or not chosen or not 0 <= min(chosen) <= max(chosen) < len(base.colors):
        return None
    colors = base.colors[chosen].astype(np.float64)
    rows = [row[: len(chosen)] for row in parts]  # what is missing is 0, and not filled up: the rest may be long
    row_of_weight = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    weights = np.array([weight for row in rows for weight in row])
    weighted = weights[:, None] * colors[[place for row in rows for place in range(len(row))]]
    totals, *sums = (np.bincount(row_of_weight, each, len(rows)) for each in (weights, *weighted.T))
    has_parts = totals > 0
    means = np.stack(sums, axis=1) / np.where(has_parts, totals, 1.0)[:, None]
    means[~has_parts] = colors.mean(axis=0)
    return np.rint(np.clip(means, 0, 255)).astype(np.uint8)


def _combine(groups: Sequence[Group], rows: Sequence[Sequence[float]]) -> Group:
    """Return the members of several groups: of these, the first that has colours and the first that has a texture."""
    found: dict[str, Any] = {}
    for name in ("colors", "texcoords"):
        for column, group in enumerate(groups):
            table = getattr(group, name)
            if table is None or not len(table) or not rows:
                continue
            chosen = np.array([int(row[column]) if column < len(row) else 0 for row in rows], np.int64)
            found[name] = table[np.where((chosen >= 0) & (chosen < len(table)), chosen, 0)]
            if name == "colors" and group.names:
                found["names"] = tuple(group.names[i] if 0 <= i < len(group.names) else "" for i in chosen)
            break
    return Group(**found)


def build_attributes(
    groups: dict[str, Group], group_of_triangle: Sequence[str | None], members: IndexArray
) -> Attributes | None:
    """Return the attributes of triangles.

    group_of_triangle : the name of the group that each triangle names
    members : (t, 3), the member of the group for each corner, -1 for none
    """
    n = len(members)
    codes: dict[str, int] = {}
    code_of_triangle = np.array([codes.setdefault(name or "", len(codes)) for name in group_of_triangle], np.int64)
    by_code = np.split(
        np.argsort(code_of_triangle, kind="stable"), np.cumsum(np.bincount(code_of_triangle, minlength=len(codes)))[:-1]
    )
    colors, has_color = np.full((n, 3, 4), 255, np.uint8), np.zeros((n, 3), bool)
    texcoords = np.full((n, 3, 2), np.nan)
    materials = np.full(n, -1, np.int32)
    labels: dict[str, int] = {}
    for name in sorted(codes):
        group = groups.get(name)
        if group is None:
            continue
        of_group = by_code[codes[name]]
        chosen = members[of_group]
        for table, target, is_set in ((group.colors, colors, has_color), (group.texcoords, texcoords, None)):
            if table is not None:
                fits = (chosen >= 0) & (chosen < len(table))
                rows, corners = np.nonzero(fits)
                target[of_group[rows], corners] = table[chosen[fits]]
                if is_set is not None:
                    is_set[of_group[rows], corners] = True
        if group.names:
            first = chosen[:, 0]
            is_named = (first >= 0) & (first < len(group.names))
            used, place = np.unique(first[is_named], return_inverse=True)
            numbers = np.array([labels.setdefault(group.names[i], len(labels)) for i in used.tolist()], np.int32)
            materials[of_group[is_named]] = numbers[place]
    corner: dict[str, Any] = {}
    face: dict[str, Any] = {}
    if has_color.any():
        colors = colors if (colors[..., 3] < 255).any() else colors[..., :3]
        if (colors == colors[:, :1]).all():
            face["color"] = colors[:, 0]
        else:
            corner["color"] = colors.reshape(-1, colors.shape[2])
    if not np.isnan(texcoords).all():
        corner["texcoord"] = texcoords.reshape(-1, 2)
    if labels:
        face["material"] = materials
    if not (corner or face):
        return None
    return Attributes(corner=corner, face=face, labels={"material": tuple(labels)} if labels else None)


def _parse_color(text: str | None) -> tuple[int, int, int, int]:
    """Return the colour that #RRGGBB or #RRGGBBAA says."""
    match = _COLOR.fullmatch((text or "").strip())
    if match is None:
        return 255, 255, 255, 255
    red, green, blue, alpha = bytes.fromhex(match[1] + (match[2] or "ff"))
    return red, green, blue, alpha


def _parse_floats(text: str | None) -> list[float]:
    """Return the finite numbers of a text, up to the first word that is none."""
    numbers: list[float] = []
    budget().take_elements(0, len(text or "") // 2)
    for word in (text or "").split():
        try:
            number = float(word)
        except ValueError:
            break
        if not abs(number) < 2**31:
            break
        numbers.append(number)
    return numbers
