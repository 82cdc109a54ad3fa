"""Colours, normals and texture coordinates of VRML's shapes.

VRML 97 keeps them in nodes of a shape, VRML 1.0 in nodes before it, with bindings that say what they are for. Section
numbers are those of ISO/IEC 14772-1 (VRML 97).
"""

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.attributes import NO_ATTRIBUTES, Attributes, transform_normals
from .limits import budget
from .vrml_nodes import PlacedNode, Visit
from .vrml_placements import Placement
from .vrml_primitives import list_parts
from .vrml_values import Numbers

MovedNormals: TypeAlias = dict[tuple[int, bytes], Float64Array]  # by list and by matrix without translation
Place: TypeAlias = Literal["point", "corner", "face"]

WHITE = (1.0, 1.0, 1.0)
_WHITE_TABLE = np.array([WHITE])
_MATERIAL_TABLE = np.array([[0.8, 0.8, 0.8]])  # of a Material that says none (6.27)
_TEXTURES = {"ImageTexture": "url", "MovieTexture": "url", "PixelTexture": "", "Texture2": "filename"}
# What a Material says beside the colour that becomes an attribute.
_LOST_OF_MATERIALS = ("ambientColor", "ambientIntensity", "emissiveColor", "shininess", "specularColor")
_COLORS_OF_MATERIALS = ("diffuseColor", "emissiveColor")
_SAID_OF_MATERIALS = {*_COLORS_OF_MATERIALS, *_LOST_OF_MATERIALS}
_PLURALS = {"color": "colours", "normal": "normals", "texcoord": "texture coordinates"}
_BEFORE_ALL = np.array([-1])
_FEW_VALUES = 64
# The parts of VRML 1.0's primitives, which may have materials of their own, for the faces in `vrml_shapes`.
_PARTS_OF_CUBE = (2, 3, 5, 4, 1, 0)  # left, right, bottom, top, back, front
_PARTS_BEHIND_SIDES = {"Cone": {"BOTTOM": 1}, "Cylinder": {"BOTTOM": 2, "TOP": 1}}


@dataclass(unsafe_hash=True)
class Appearance:
    """The nodes that say how the shapes behind them look; bindings are of VRML 1.0 alone.

    Nobody may change one; frozen it would take three times as long to make.
    """

    material: PlacedNode | None = None
    material_binding: str = "DEFAULT"
    normal: PlacedNode | None = None
    normal_binding: str = "DEFAULT"
    texcoord: PlacedNode | None = None
    texture: PlacedNode | None = None

    @property
    def colors_of_faces(self) -> Float64Array:
        """The colours (n, 3), or (n, 4) with opacities, of the material; white without one."""
        return self._of_faces[0]

    @property
    def colors_of_lines(self) -> Float64Array:
        """The same for lines and points."""
        return self._of_lines[0]

    @property
    def color_of_faces(self) -> Float64Array:
        """The first of them: (1, 3) or (1, 4)."""
        return self._of_faces[1]

    @property
    def color_of_lines(self) -> Float64Array:
        """The same for lines and points."""
        return self._of_lines[1]

    @cached_property
    def _of_faces(self) -> tuple[Float64Array, Float64Array]:
        """Both, as each `cached_property` takes a lock, and as shapes share the first row."""
        return _with_first(_read_material(self.material, is_line=False))

    @cached_property
    def _of_lines(self) -> tuple[Float64Array, Float64Array]:
        return _with_first(_read_material(self.material, is_line=True))

    @property
    def says_color(self) -> bool:
        """Whether the file says a colour, so that it is not by default."""
        return self._said[0]

    @property
    def texture_name(self) -> str | None:
        """The name of the texture, or its kind; None without one."""
        return self._said[1]

    @property
    def lost(self) -> tuple[str, ...]:
        """What the material says that no attribute holds."""
        return self._said[2]

    @cached_property
    def _said(self) -> tuple[bool, str | None, tuple[str, ...]]:
        """All three, which most appearances are asked for."""
        says_color, name = False, None
        lost: tuple[str, ...] = ()
        if self.material is not None:
            said = self.material.node.fields.keys() & _SAID_OF_MATERIALS  # of a dozen fields, few are there
            found = {field for field in said if self.material.numbers(field) is not None}
            says_color = not found.isdisjoint(_COLORS_OF_MATERIALS)
            lost = tuple(field for field in _LOST_OF_MATERIALS if field in found)
        if self.texture is not None and self.texture.kind in _TEXTURES:
            name = self.texture.first_word(_TEXTURES[self.texture.kind]) or self.texture.kind
        return says_color, name, lost


NO_APPEARANCE = Appearance()


def _with_first(rows: Float64Array) -> tuple[Float64Array, Float64Array]:
    return rows, rows if len(rows) == 1 else rows[:1]


class Corners:
    """The list `coordIndex` of a shape, in which -1 ends each polygon or polyline.

    places : where in the list the corners are
    sizes : how many corners each polygon or polyline has
    highest : the highest index, -1 if there is none
    """

    def __init__(self, values: IndexArray, places: IndexArray, sizes: IndexArray, highest: int) -> None:
        self.values, self.places, self.sizes, self.highest = values, places, sizes, highest

    @classmethod
    def split(cls, values: IndexArray, highest: int) -> "Corners":
        """Return a list that has values, split into runs."""
        is_end = values == -1
        ends = is_end.nonzero()[0]
        n = len(values)
        if len(ends) == 0:
            return cls(values, np.arange(n), np.array([n]), highest)
        if len(ends) == 1 and ends[0] == n - 1 > 0:
            return cls(values, np.arange(n - 1), np.array([n - 1]), highest)
        ends = np.concatenate([_BEFORE_ALL, ends, [n]])
        sizes = ends[1:] - ends[:-1] - 1
        return cls(values, (~is_end).nonzero()[0], sizes[sizes > 0], highest)

    @property
    def n_rows(self) -> int:
        """How many polygons or polylines it has."""
        return len(self.sizes)

    @cached_property
    def is_corner(self) -> BoolArray:
        """Which values are no ends."""
        is_corner: BoolArray = self.values != -1
        return is_corner

    @cached_property
    def row(self) -> IndexArray:
        """The polygon or polyline of each value; of -1, the one before."""
        begins = self.is_corner & ~np.concatenate([[False], self.is_corner[:-1]])
        return np.cumsum(begins) - 1


class Column(NamedTuple):
    """An attribute of a shape: `rows` (n, k) of numbers, and which of them each value or each row of `Corners` has.

    chosen : None if there is one for all
    """

    rows: Float64Array
    chosen: IndexArray | None
    is_per_corner: bool


class NormalColumn(NamedTuple):
    """The normals of a shape, not moved yet, of a list that other shapes may share; else as `Column`."""

    numbers: Numbers
    rows: Float64Array
    chosen: IndexArray
    is_per_corner: bool

    def moved(self, placement: Placement, known: MovedNormals) -> Column:
        """Return the normals of the shape in the world.

        known : lists that were moved for shapes before it, to which this one's is added
        """
        _, rows, chosen, is_per_corner = self
        if placement.matrix is None:
            return Column(rows, chosen, is_per_corner)
        if len(rows) > len(chosen):  # of a list that many shapes share
            return Column(transform_normals(rows[chosen], placement.linear), np.arange(len(chosen)), is_per_corner)
        key = id(self.numbers), placement.linear_key
        if key not in known:
            known[key] = transform_normals(rows, placement.linear)
        return Column(known[key], chosen, is_per_corner)


@dataclass
class AttributeBuilder:
    """The attributes of the shapes so far, and what was left out of them."""

    columns: dict[tuple[Place, str], list[tuple[int, int, Float64Array]]] = field(default_factory=dict)
    """For each attribute the first row that an array is for, how many rows, and the array, maybe one row for all."""
    has_colors: bool = False
    """Whether the file says a colour at all."""
    textures: dict[str, None] = field(default_factory=dict)
    lost: set[str] = field(default_factory=set)
    misfits: Counter[str] = field(default_factory=Counter)

    def add(self, place: Place, name: str, start: int, rows: Float64Array, n: int | None = None) -> None:
        """Add the rows of an attribute from row `start` on: as many as there are, or one that stands for `n`."""
        if len(rows) == 0:
            return
        parts = self.columns.setdefault((place, name), [])
        n = len(rows) if n is None else n
        if parts and len(rows) == 1 and parts[-1][2] is rows and sum(parts[-1][:2]) == start:  # of shapes of one colour
            start, n = parts[-1][0], parts.pop()[1] + n
        parts.append((start, n, rows))

    def note(self, appearance: Appearance) -> None:
        """Note the texture of a shape, and what of its material no attribute holds."""
        if appearance.texture_name is not None:
            self.textures[appearance.texture_name] = None
        if appearance.lost:
            self.lost.update(appearance.lost)

    def describe_losses(self) -> list[str]:
        """Return words for what other formats cannot hold, as no attribute does."""
        textures = [f"{len(self.textures)} textures"] if len(self.textures) > 1 else []
        return textures + ([f"{', '.join(sorted(self.lost))} of materials"] if self.lost else [])

    def describe_misfits(self) -> str:
        """Return words for the attributes that were left out, for they do not fit their shapes."""
        return ", ".join(f"{_PLURALS[name]} of {count} shapes" for name, count in sorted(self.misfits.items()))

    def build(self, n_points: int, offsets: IndexArray, indices: IndexArray) -> Attributes:
        """Return the attributes of the whole mesh; what has one value at each point is per point."""
        counts: dict[Place, int] = {"point": n_points, "corner": len(indices), "face": len(offsets) - 1}
        sizes = np.diff(offsets)
        tables: dict[Place, dict[str, Float64Array]] = {"point": {}, "corner": {}, "face": {}}
        for name in ("color", "normal", "texcoord"):
            if name == "color" and not self.has_colors:
                continue
            found = {place: self._fill(place, name, counts[place]) for place in counts if (place, name) in self.columns}
            if "corner" in found and "face" in found:  # one place for all, so that no one hides another
                is_of_face = np.repeat(self._is_set("face", name, counts["face"]), sizes)
                of_face = np.repeat(found.pop("face"), sizes, axis=0)
                found["corner"], of_face = _widen(found["corner"], of_face)
                found["corner"] = np.where(is_of_face[:, np.newaxis], of_face, found["corner"])
            if "corner" in found:
                merged = _merge_per_point(found["corner"], indices, found.get("point"), n_points)
                if merged is not None:
                    found = {"point": merged}
            for place, table in found.items():
                table.flags.writeable = False  # else it would be copied
                tables[place][name] = table
        material = {"texture": next(iter(self.textures))} if len(self.textures) == 1 else None
        if not (any(tables.values()) or material):
            return NO_ATTRIBUTES
        return Attributes(**tables, material=material)

    def _fill(self, place: Place, name: str, count: int) -> Float64Array:
        """Return an attribute for all rows: white, or NaN, where no shape has it."""
        parts = self.columns[place, name]
        width = max(rows.shape[1] for _, _, rows in parts)
        table = np.full((count, width), 1.0 if name == "color" else np.nan)
        for start, n, rows in parts:
            table[start : start + n, : rows.shape[1]] = rows
        return table

    def _is_set(self, place: Place, name: str, count: int) -> BoolArray:
        found = np.zeros(count, bool)
        for start, n, _ in self.columns[place, name]:
            found[start : start + n] = True
        return found


def _widen(a: Float64Array, b: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return two tables of equally many columns; ones fill the narrower."""
    width = max(a.shape[1], b.shape[1])
    first, second = (np.pad(table, ((0, 0), (0, width - table.shape[1])), constant_values=1.0) for table in (a, b))
    return first, second


def _merge_per_point(
    corner: Float64Array, indices: IndexArray, point: Float64Array | None, n_points: int
) -> Float64Array | None:
    """Return the table per point if all corners of each point have the same row, else None."""
    table = np.full((n_points, corner.shape[1]), 1.0 if np.isfinite(corner).all() else np.nan)
    if point is not None:
        table, corner = _widen(point, corner)
        table = table.copy()
    table[indices] = corner
    return table if np.array_equal(table[indices], corner, equal_nan=True) else None


def read_color(shape: PlacedNode, appearance: Appearance, corners: Corners, *, is_vrml1: bool, visit: Visit) -> Column:
    """Return the colours of a face set or a line set. Raises MeshError if they do not fit it."""
    color = _find(shape, "color", "color", visit)
    if color is not None:
        is_per_corner = shape.flag("colorPerVertex", True)
        chosen = _choose(shape, "colorIndex", corners, is_per_corner)
        return Column(_rows_of(color, "color", 3, chosen, is_per_corner, corners), chosen, is_per_corner)
    is_line = shape.kind == "IndexedLineSet"
    table = appearance.colors_of_lines if is_line else appearance.colors_of_faces
    binding = appearance.material_binding if is_vrml1 else "OVERALL"
    if len(table) == 1 or binding in ("DEFAULT", "OVERALL"):
        return Column(appearance.color_of_lines if is_line else appearance.color_of_faces, None, is_per_corner=False)
    is_per_corner = binding.startswith("PER_VERTEX")
    chosen = _choose_bound(shape, "materialIndex", corners, binding)
    return Column(table, np.where(chosen < 0, chosen, chosen % len(table)), is_per_corner)


def _find(shape: PlacedNode, name: str, field_name: str, visit: Visit) -> PlacedNode | None:
    """Return the node that a shape names, None without one, or for one that has no numbers."""
    named = shape.first(name)
    node = None if named is None else named.expanded(visit)
    return None if node is None or node.numbers(field_name) is None else node


def read_colors_of_points(shape: PlacedNode, appearance: Appearance, n_points: int, visit: Visit) -> Float64Array:
    """Return the colours (n, k) of a point set, or (1, k) for all points. Raises MeshError if they do not fit it."""
    color = _find(shape, "color", "color", visit)
    if color is not None:
        table = color.table("color", 3)
    elif appearance.material_binding.startswith("PER_"):
        table = appearance.colors_of_lines
    else:
        table = appearance.color_of_lines
    if len(table) == 1:
        return table
    if len(table) < n_points:
        raise MeshError(f"line {shape.line}: {len(table)} colours for {n_points} points")
    return table[:n_points]


def read_parts(shape: PlacedNode, appearance: Appearance, n_faces: int, *, is_vrml1: bool) -> Float64Array:
    """Return the colours (n_faces, k) of a primitive, or (1, k) that all faces have."""
    table = appearance.colors_of_faces
    if len(table) > 1 and is_vrml1 and appearance.material_binding.startswith("PER_PART"):
        part = np.zeros(n_faces, np.int64)
        if shape.kind == "Cube":
            part = np.array(_PARTS_OF_CUBE)
        elif shape.kind in _PARTS_BEHIND_SIDES:
            known = list_parts(shape)
            caps = [number for name, number in _PARTS_BEHIND_SIDES[shape.kind].items() if name in known]
            part[n_faces - len(caps) :] = caps
        return table[part % len(table)]
    return appearance.color_of_faces


def says_color(shape: PlacedNode, appearance: Appearance) -> bool:
    """Return whether a file says the colour of a shape, so that it is not by default."""
    return shape.first("color") is not None or appearance.says_color


def read_normal(
    shape: PlacedNode, appearance: Appearance, corners: Corners, *, is_vrml1: bool, visit: Visit
) -> NormalColumn | None:
    """Return the normals of a face set, None if it has none. Raises MeshError if they do not fit it."""
    own = shape.first("normal")
    if own is not None:
        node = own.expanded(visit)
        is_per_corner = shape.flag("normalPerVertex", True)
        chosen = _choose(shape, "normalIndex", corners, is_per_corner)
    elif is_vrml1 and appearance.normal is not None:
        node, binding = appearance.normal, appearance.normal_binding
        if binding == "OVERALL":
            binding = "PER_FACE" if corners.n_rows == 1 else ""
        binding = "PER_VERTEX_INDEXED" if binding == "DEFAULT" else binding
        is_per_corner = binding.startswith("PER_VERTEX")
        chosen = _choose_bound(shape, "normalIndex", corners, binding)
    else:
        return None
    if node is None or (numbers := node.numbers("vector")) is None or numbers.is_blank():
        return None
    rows = _rows_of(node, "vector", 3, chosen, is_per_corner, corners)
    return NormalColumn(numbers, rows, chosen, is_per_corner)


def read_texcoord(
    shape: PlacedNode, appearance: Appearance, corners: Corners, *, is_vrml1: bool, visit: Visit
) -> Column | None:
    """Return the texture coordinates of a face set, None if it has none. Raises MeshError if they do not fit it."""
    own = shape.first("texCoord")
    if own is not None:
        node, index = own.expanded(visit), "texCoordIndex"
    elif is_vrml1 and appearance.texcoord is not None and appearance.texture is not None:
        node, index = appearance.texcoord, "textureCoordIndex"
    else:
        return None
    if node is None or node.numbers("point") is None:
        return None
    chosen = _choose(shape, index, corners, is_per_corner=True)
    return Column(_rows_of(node, "point", 2, chosen, True, corners), chosen, is_per_corner=True)


def _read_material(material: PlacedNode | None, *, is_line: bool) -> Float64Array:
    """Return the colours (n, 3), or (n, 4) with opacities, of a material; white without one.

    Lines and points shine, where a file says so, and faces reflect (6.27).
    """
    if material is None:
        return _WHITE_TABLE
    table = material.table("diffuseColor", 3)
    if is_line or len(table) == 0:
        emissive = material.table("emissiveColor", 3)
        table = emissive if len(table) == 0 or emissive.any() else table
    if len(table) == 0:
        table = _MATERIAL_TABLE
    if material.numbers("transparency") is None:
        return table
    opacity = 1.0 - material.table("transparency", 1)[:, 0]
    if not len(opacity) or (opacity == 1.0).all():
        return table
    n = max(len(table), len(opacity)) if min(len(table), len(opacity)) == 1 else len(table)
    rows = np.arange(n)
    return np.column_stack([table[rows % len(table)], np.clip(opacity[rows % len(opacity)], 0.0, 1.0)])


def _choose_bound(shape: PlacedNode, index: str, corners: Corners, binding: str) -> IndexArray:
    """Return which rows a shape of VRML 1.0 has by a binding."""
    is_per_corner = binding.startswith("PER_VERTEX")
    if binding.endswith("_INDEXED"):
        return _choose(shape, index, corners, is_per_corner)
    if is_per_corner:
        chosen = np.full(len(corners.values), -1)
        chosen[corners.places] = np.arange(len(corners.places))
        return chosen
    if binding in ("PER_FACE", "PER_PART"):
        return np.arange(corners.n_rows)
    raise MeshError(f"line {shape.line}: {shape.kind} has no meaning for {binding or 'OVERALL'}")


def _choose(shape: PlacedNode, index: str, corners: Corners, is_per_corner: bool) -> IndexArray:
    """Return which rows a shape has: those of its list `index`, else those of `coordIndex`, or one per face (6.23)."""
    numbers = shape.numbers(index)
    if numbers is None:
        return corners.values if is_per_corner else np.arange(corners.n_rows)
    own = numbers.integers()
    budget().take_numbers(len(own), shape.line)
    own = own[own >= 0]
    n, what = (len(corners.places), "corners") if is_per_corner else (corners.n_rows, "faces")
    if len(own) == 0:
        return corners.values if is_per_corner else np.arange(n)
    if len(own) < n:
        raise MeshError(f"line {shape.line}: {index} has {len(own)} numbers for {n} {what}")
    if not is_per_corner:
        return own[:n]
    chosen = np.full(len(corners.values), -1)
    chosen[corners.places] = own[:n]
    return chosen


def _rows_of(
    node: PlacedNode, name: str, width: int, chosen: IndexArray, is_per_corner: bool, corners: Corners
) -> Float64Array:
    """Return the rows of a field, all of which `chosen` must name."""
    rows = node.table(name, width)
    lowest, highest = 0, corners.highest
    if chosen is not corners.values:
        lowest, highest = find_range(chosen[corners.places] if is_per_corner else chosen)
    if lowest < 0 or highest >= len(rows):
        raise MeshError(f"line {node.line}: {name} has {len(rows)} rows, its shape names row {highest}")
    return rows


def find_range(values: IndexArray) -> tuple[int, int]:
    """Return the least and the greatest of some integers, 0 and -1 if there are none."""
    if len(values) <= _FEW_VALUES:  # NumPy takes longer
        few = values.tolist()
        return (min(few), max(few)) if few else (0, -1)
    return int(values.min()), int(values.max())
