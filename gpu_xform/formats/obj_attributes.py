"""Attributes of OBJ: texture coordinates, normals, colours, materials, groups and objects."""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .._core.widen import widen
from ..geometry.attributes import NO_ATTRIBUTES, Attributes, RaggedArray, freeze_value, thaw_value
from ..geometry.mesh import Mesh
from ._line_names import list_name_losses, make_comment, make_line, make_names
from ._losses import list_material_losses
from ._warn import warn
from .obj_materials import find_images, list_libraries, parse_materials, read_libraries

# Statements that hold for the faces behind them, and the attributes per face that they become.
STATES = {b"o": "object", b"g": "group", b"usemtl": "material", b"s": "smooth"}
KEYWORDS = {name: keyword for keyword, name in STATES.items()}
BESIDE_WIDTHS = 1, 3, 4  # numbers behind coordinates: a weight, or a colour
_WORDS = {"texcoord": "texture coordinates", "normal": "normals"}
# Curves and surfaces, and what is read of all that belongs to them.
SHAPES = frozenset({"bsp", "bzp", "cdc", "cdp", "curv", "curv2", "surf"})
FREE_FORMS = SHAPES | {"cstype", "deg", "end", "hole", "parm", "trim"}
_MAX_NAMED = 8


@dataclass
class Extras:
    """What a file says beside points and faces."""

    texcoords: Float64Array | None = None
    """The numbers behind each `vt`."""
    normals: Float64Array | None = None
    texcoord_of_corner: IndexArray | None = None
    """The row of `texcoords` for each corner, -1 for none."""
    normal_of_corner: IndexArray | None = None
    n_beside_points: int = 0
    """How many numbers at most stand behind the coordinates of a point."""
    beside_points: Float64Array | None = None
    """These numbers, if so many have a meaning."""
    states: list[tuple[int, bytes, str]] = field(default_factory=list)
    """The faces before a statement, its keyword, and the rest of it."""
    libraries: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    drawn_points: list[tuple[int, str]] = field(default_factory=list)
    """The points before a statement `p`, and the rest of it."""
    unread: Counter[str] = field(default_factory=Counter)
    """How often each statement stands there that is not read."""
    free_forms: list[tuple[int, int, int, int, str]] = field(default_factory=list)
    """The line of a statement about curves and surfaces; the points, faces and states before it; and its words."""
    not_shown: Counter[str] = field(default_factory=Counter)
    """How many of each kind of curves and surfaces are not in the mesh."""
    reasons: list[str] = field(default_factory=list)
    """Why they are not, with the line."""
    left_out: list[str] = field(default_factory=list)
    """Words for what has no place in a mesh."""


def build_attributes(extras: Extras, n_points: int, n_faces: int) -> Attributes:
    """Return the attributes that a file holds, and note what else it does."""
    point: dict[str, Any] = {}
    corner, face, labels = {}, {}, {}
    beside = extras.beside_points
    if beside is not None:
        point |= {"weight": beside[:, 0]} if beside.shape[1] == 1 else {"color": beside}
    elif extras.n_beside_points:
        extras.left_out.append(f"{extras.n_beside_points} numbers behind each point")
    for name, rows, chosen in (
        ("texcoord", extras.texcoords, extras.texcoord_of_corner),
        ("normal", extras.normals, extras.normal_of_corner),
    ):
        if rows is None:
            continue
        if name == "normal" and (n_wrong := np.count_nonzero(~np.isfinite(rows).all(axis=1))):
            warn(f"normals that are not three finite numbers: {n_wrong}; they are left out where the mesh moves")
        n_named = 0
        if chosen is not None and (chosen != -1).any():
            corner[name] = _gather(rows, chosen, name)
            n_named = int(_find_named(chosen, len(rows)).sum())
        elif n_faces == 0 and len(rows) == n_points:  # a cloud, in which row i is for point i
            point[name] = rows
            n_named = n_points
        if n_named < len(rows):
            extras.left_out.append(f"{len(rows) - n_named} {_WORDS[name]} that no face names")
    for keyword, name in STATES.items():
        found = [(before, text) for before, word, text in extras.states if word == keyword and before < n_faces]
        if found:
            texts = {text: i for i, text in enumerate(dict.fromkeys(text for _, text in found))}
            starts = [before for before, _ in found]
            lengths = np.diff([0, *starts, n_faces])
            face[name] = np.repeat(np.array([-1, *(texts[text] for _, text in found)], np.int32), lengths)
            labels[name] = tuple(texts)
    material = {"mtllib": extras.libraries} if extras.libraries else None
    if not (point or corner or face or material):
        return NO_ATTRIBUTES
    return Attributes(point, corner, face, labels=labels, material=material)


def add_materials(mesh: Mesh, folder: Path | None) -> Mesh:
    """Return the mesh with the materials of the `.mtl` files that it names and that lie in `folder` or below."""
    attributes = mesh.attributes
    names = attributes.material["mtllib"]
    libraries = read_libraries(names, folder)
    used = set(attributes.labels.get("material", ()))
    found = {name: value for name, value in parse_materials(libraries).items() if name in used and name != "mtllib"}
    if not libraries:
        return mesh
    held = {**mesh.metadata.get("obj", {}), "libraries": libraries, "images": find_images(libraries, folder, used)}
    return mesh.with_attributes(
        Attributes(
            attributes.point,
            attributes.corner,
            attributes.face,
            labels=attributes.labels,
            material={**thaw_value(attributes.material), **found},
        ),
        metadata={**mesh.metadata, "obj": held},
    )


def _find_named(chosen: IndexArray, n_rows: int) -> BoolArray:
    """Return which rows are chosen at least once."""
    is_named = np.zeros(n_rows, bool)
    is_named[chosen[(chosen >= 0) & (chosen < n_rows)]] = True
    return is_named


def _gather(rows: Float64Array, chosen: IndexArray, name: str) -> Float64Array:
    """Return the chosen rows; a row of NaNs stands for none."""
    absent = (chosen < -1) | (chosen >= len(rows))
    if absent.any():
        warn(f"{absent.sum()} corners name {_WORDS[name]} that the file does not hold")
        chosen = np.where(absent, -1, chosen)
    if chosen.min() >= 0:
        return rows[chosen]
    return np.concatenate([rows, np.full((1, rows.shape[1]), np.nan)])[chosen]


def describe_file(extras: Extras, n_points: int) -> dict[str, Any]:
    """Return the comments, the points that are drawn by themselves, and words for what other formats would lose."""
    found: dict[str, Any] = {}
    if extras.comments:
        n_comments = len(extras.comments)
        found |= {"comments": extras.comments, "holds": [f"{n_comments} comment{'s'[: n_comments - 1]}"]}
    drawn = _read_drawn_points(extras, n_points)
    if len(drawn):
        found["drawn_points"] = drawn
    if extras.not_shown:
        reason = f"; {extras.reasons[0]}" if extras.reasons else ""
        warn(f"not shown: {_list_counts(extras.not_shown)}{reason}")
    if left_out := extras.not_shown + extras.unread:
        extras.left_out.append(_list_counts(left_out))
    if extras.left_out:
        found["left_out"] = extras.left_out
    return {"obj": found} if found else {}


def _list_counts(counts: Counter[str]) -> str:
    """Return such as "3 surf, 2 lod"."""
    named = counts.most_common(_MAX_NAMED)
    n_more = sum(counts.values()) - sum(count for _, count in named)
    return ", ".join(f"{count} {name}" for name, count in named) + (f" and {n_more} more" if n_more else "")


def _read_drawn_points(extras: Extras, n_points: int) -> IndexArray:
    """Return the points that statements `p` name; those that do not exist are left out with a warning."""
    found: list[int] = []
    n_wrong = 0
    for before, text in extras.drawn_points:
        for word in text.split():
            try:
                value = int(word)
            except ValueError:
                value = 0
            point = value - 1 if value > 0 else before + value
            if value and 0 <= point < n_points:
                found.append(point)
            else:
                n_wrong += 1
    if n_wrong:
        warn(f"{n_wrong} points that p names are left out, for the file does not hold them")
    return np.array(found, np.int64)


def list_losses(mesh: Mesh) -> list[str]:
    """Return what of a mesh OBJ cannot hold."""
    attributes = mesh.attributes
    held = {
        "point": ("color", "weight", "normal", "texcoord"),
        "corner": ("normal", "texcoord"),
        "face": tuple(KEYWORDS),
    }
    lost = []
    for what, names in held.items():
        for name, column in getattr(attributes, what).items():
            if name not in names or not _can_hold(name, column, attributes.labels) or _is_absent(mesh, name, column):
                lost.append(f"{name} per {what}")
            elif what == "point" and name in attributes.corner:
                lost.append(f"{name} per point beside those per corner")
            elif name == "weight" and "color" in attributes.point and _can_hold("color", attributes.point["color"], ()):
                lost.append("weight per point beside color")
            elif what == "face":
                lost += _list_state_losses(name, column, attributes.labels[name])
    if _have_segments_normals(mesh):
        lost.append("normals of segments")
    described = mesh.metadata.get("obj", {})
    if any(make_comment(text) != text for text in described.get("comments", ())):
        lost.append("line ends in comments")
    libraries = list_libraries(attributes.material)
    lost += list_name_losses(libraries, "mtllib", "material libraries")
    written = parse_materials(described.get("libraries", {}))
    others = {
        name: value
        for name, value in attributes.material.items()
        if not (name == "mtllib" and value is libraries)
        and not (name in written and value == freeze_value(written[name]))
    }
    return lost + list_material_losses(others, attributes.labels.get("material", ()))


def _list_state_losses(name: str, column: IndexArray, texts: Sequence[str]) -> list[str]:
    """Return what is lost of labels: names that a line does not hold, and faces that have none, for none ends."""
    lost = list_name_losses(texts, KEYWORDS[name].decode(), name)
    is_named = (column >= 0) & (column < len(texts))
    return lost + ([f"faces without {name} behind others"] if (is_named[:-1] & ~is_named[1:]).any() else [])


def _can_hold(name: str, column: Any, labels: Collection[str]) -> bool:
    """Return whether OBJ has a statement for such values."""
    if isinstance(column, RaggedArray) or column.dtype.kind not in "biuf":
        return False
    if name in KEYWORDS:
        return column.ndim == 1 and column.dtype.kind in "iu" and name in labels
    widths = {"color": (3, 4), "weight": (1,), "normal": (3,), "texcoord": (1, 2, 3)}[name]
    return (column.shape[1] if column.ndim == 2 else column.ndim) in widths


def _is_absent(mesh: Mesh, name: str, column: Any) -> bool:
    """Return whether no corner of any face has these normals or texture coordinates."""
    return name in _WORDS and mesh.n_faces > 0 and bool(np.isnan(column).all())


def _have_segments_normals(mesh: Mesh) -> bool:
    """Return whether a corner of a segment has the normals that are written."""
    sizes = np.diff(mesh.offsets)
    of_segment = np.repeat(sizes == 2, sizes)
    for table, of_corner in ((mesh.attributes.corner, slice(None)), (mesh.attributes.point, mesh.indices)):
        column = table.get("normal")
        if column is not None and _can_hold("normal", column, ()):
            return not np.isnan(column[of_corner][of_segment]).all()
    return False


def list_rows(mesh: Mesh, name: str) -> tuple[Float64Array | None, IndexArray | None]:
    """Return the different rows of normals or texture coordinates, and the row of each corner, -1 for none."""
    for table, of_corner in ((mesh.attributes.corner, slice(None)), (mesh.attributes.point, mesh.indices)):
        column = table.get(name)
        if column is not None and _can_hold(name, column, {}):
            rows = widen(column).reshape(len(column), -1)
            if mesh.n_faces == 0:
                return rows, None
            first, inverse = _find_different(rows)
            inverse[np.isnan(rows).all(axis=1)] = -1
            is_used = ~np.isnan(rows[first]).all(axis=1)
            ranks = np.append(np.where(is_used, np.cumsum(is_used) - 1, -1), -1)
            return rows[first[is_used]], ranks[inverse][of_corner]
    return None, None


def _find_different(rows: Float64Array) -> tuple[IndexArray, IndexArray]:
    """Return the first of all equal rows, in the order of the rows, and for each row its place among them."""
    keys = np.ascontiguousarray(rows).view(f"V{rows.shape[1] * rows.itemsize}").ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    ranks = np.empty(len(order), np.int64)
    ranks[order] = np.arange(len(order))
    return first[order], ranks[inverse.ravel()]


def list_beside_points(mesh: Mesh) -> Float64Array | None:
    """Return the numbers to write behind the coordinates of points."""
    for name in ("color", "weight"):
        column = mesh.attributes.point.get(name)
        if column is not None and _can_hold(name, column, {}):
            values = widen(column).reshape(len(column), -1)
            return values / 255 if column.dtype == np.uint8 else values
    return None


def split_states(mesh: Mesh) -> Sequence[tuple[int, int, bytes]]:
    """Return runs of faces in one state: the first, the one behind the last, and the statements before them."""
    attributes = mesh.attributes
    states = {
        name: np.asarray(attributes.face[name])
        for name in KEYWORDS
        if name in attributes.face and _can_hold(name, attributes.face[name], attributes.labels)
    }
    keywords = {name: KEYWORDS[name].decode() for name in states}
    written = {name: make_names(attributes.labels[name], keyword) for name, keyword in keywords.items()}
    starts = {0}
    for values in states.values():
        starts.update((np.flatnonzero(np.diff(values)) + 1).tolist())
    runs = []
    before = dict.fromkeys(states, -1)
    ordered = sorted(starts)
    for start, end in zip(ordered, [*ordered[1:], mesh.n_faces], strict=True):
        lines = b""
        for name, values in states.items():
            value = int(values[start]) if start < end else -1
            if value != before[name] and 0 <= value < len(attributes.labels[name]):
                lines += make_line(f"{keywords[name]} ", written[name][attributes.labels[name][value]])
            before[name] = value
        runs.append((start, end, lines))
    return runs
