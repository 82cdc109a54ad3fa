"""Colours, normals and texture coordinates of VRML's shapes.

VRML 97 keeps them in nodes of a shape, VRML 1.0 in nodes before it, with bindings that say what they are for. Section
numbers are those of ISO/IEC 14772-1 (VRML 97).
"""

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.attributes import NO_ATTRIBUTES, Attributes, transform_normals
from .limits import budget
from .vrml_nodes import PlacedNode, Visit
from .vrml_primitives import list_parts

MovedNormals: TypeAlias = dict[tuple[int, bytes], Float64Array]
Place: TypeAlias = Literal["point", "corner", "face"]

UNMOVED = np.eye(4)
WHITE = (1.0, 1.0, 1.0)
_WHITE_TABLE = np.array([WHITE])
_MATERIAL_COLOR = (0.8, 0.8, 0.8)  # of a Material that says none (6.27)
_TEXTURES = {"ImageTexture": "url", "MovieTexture": "url", "PixelTexture": "", "Texture2": "filename"}
# What a Material says beside the colour that becomes an attribute.
_LOST_OF_MATERIALS = ("ambientColor", "ambientIntensity", "emissiveColor", "shininess", "specularColor")
_PLURALS = {"color": "colours", "normal": "normals", "texcoord": "texture coordinates"}
# The parts of VRML 1.0's primitives, which may have materials of their own, for the faces in `vrml_shapes`.
_PARTS_OF_CUBE = (2, 3, 5, 4, 1, 0)  # left, right, bottom, top, back, front
_PARTS_BEHIND_SIDES = {"Cone": {"BOTTOM": 1}, "Cylinder": {"BOTTOM": 2, "TOP": 1}}


@dataclass(frozen=True)
class Appearance:
    """The nodes that say how the shapes behind them look; bindings are of VRML 1.0 alone."""

    material: PlacedNode | None = None
    material_binding: str = "DEFAULT"
    normal: PlacedNode | None = None
    normal_binding: str = "DEFAULT"
    texcoord: PlacedNode | None = None
    texture: PlacedNode | None = None

    @cached_property
    def colors_of_faces(self) -> Float64Array:
        """The colours (n, 3), or (n, 4) with opacities, of the material; white without one."""
        return _read_material(self.material, is_line=False)

    @cached_property
    def colors_of_lines(self) -> Float64Array:
        """The same for lines and points."""
        return _read_material(self.material, is_line=True)


NO_APPEARANCE = Appearance()


@dataclass(frozen=True)
class Corners:
    """The list `coordIndex` of a shape, in which -1 ends each polygon or polyline."""

    values: IndexArray
    is_corner: BoolArray
    sizes: IndexArray
    """How many corners each polygon or polyline has."""

    @classmethod
    def split(cls, values: IndexArray) -> "Corners":
        """Return the list, split into runs."""
        is_corner = values != -1
        ends = np.concatenate([[-1], (values == -1).nonzero()[0], [len(values)]])
        sizes = ends[1:] - ends[:-1] - 1
        return cls(values, is_corner, sizes if sizes.all() else sizes[sizes > 0])

    @property
    def n_rows(self) -> int:
        """How many polygons or polylines it has."""
        return len(self.sizes)

    @cached_property
    def row(self) -> IndexArray:
        """The polygon or polyline of each value; of -1, the one before."""
        begins = self.is_corner & ~np.concatenate([[False], self.is_corner[:-1]])
        return np.cumsum(begins) - 1


@dataclass(frozen=True)
class Column:
    """An attribute of a shape: `rows` (n, k) of numbers, and which of them each value or each row of `Corners` has.

    chosen : None if there is one for all
    """

    rows: Float64Array
    chosen: IndexArray | None
    is_per_corner: bool


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
        if len(rows):
            self.columns.setdefault((place, name), []).append((start, len(rows) if n is None else n, rows))

    def note(self, appearance: Appearance) -> None:
        """Note the texture of a shape, and what of its material no attribute holds."""
        if appearance.texture is not None and appearance.texture.kind in _TEXTURES:
            names = appearance.texture.words(_TEXTURES[appearance.texture.kind])
            name = names[0] if names and names[0] else appearance.texture.kind
            self.textures[name] = None
        if appearance.material is not None:
            self.lost.update(name for name in _LOST_OF_MATERIALS if appearance.material.numbers(name) is not None)

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
    color = next(iter(shape.nodes("color")), None)
    color = None if color is None else color.expanded(visit)
    if color is not None and color.numbers("color") is not None:
        is_per_corner = shape.flag("colorPerVertex", True)
        chosen = _choose(shape, "colorIndex", corners, is_per_corner)
        return Column(_rows_of(color, "color", 3, chosen, is_per_corner, corners), chosen, is_per_corner)
    table = appearance.colors_of_lines if shape.kind == "IndexedLineSet" else appearance.colors_of_faces
    binding = appearance.material_binding if is_vrml1 else "OVERALL"
    if len(table) == 1 or binding in ("DEFAULT", "OVERALL"):
        return Column(table[:1], None, is_per_corner=False)
    is_per_corner = binding.startswith("PER_VERTEX")
    chosen = _choose_bound(shape, "materialIndex", corners, binding)
    return Column(table, np.where(chosen < 0, chosen, chosen % len(table)), is_per_corner)


def read_colors_of_points(shape: PlacedNode, appearance: Appearance, n_points: int, visit: Visit) -> Float64Array:
    """Return the colours (n, k) of a point set, or (1, k) for all points. Raises MeshError if they do not fit it."""
    color = next(iter(shape.nodes("color")), None)
    color = None if color is None else color.expanded(visit)
    if color is not None and color.numbers("color") is not None:
        table = color.table("color", 3)
    else:
        table = appearance.colors_of_lines
        if not appearance.material_binding.startswith("PER_"):
            table = table[:1]
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
    return table[:1]


def says_color(shape: PlacedNode, appearance: Appearance) -> bool:
    """Return whether a file says the colour of a shape, so that it is not by default."""
    fields = ("diffuseColor", "emissiveColor")
    material = appearance.material
    return bool(shape.nodes("color")) or (
        material is not None and any(material.numbers(name) is not None for name in fields)
    )


def read_normal(
    shape: PlacedNode,
    appearance: Appearance,
    corners: Corners,
    matrix: Float64Array,
    moved: MovedNormals,
    *,
    is_vrml1: bool,
    visit: Visit,
) -> Column | None:
    """Return the normals of a face set in the world, None if it has none. Raises MeshError if they do not fit it.

    moved : lists that were moved for shapes before it, to which this one's is added
    """
    own = next(iter(shape.nodes("normal")), None)
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
    if node is None or (numbers := node.numbers("vector")) is None or not numbers.text.strip():
        return None
    rows = _rows_of(node, "vector", 3, chosen, is_per_corner, corners)
    if matrix is UNMOVED:
        return Column(rows, chosen, is_per_corner)
    if len(rows) > len(chosen):  # of a list that many shapes share
        return Column(transform_normals(rows[chosen], matrix[:3, :3]), np.arange(len(chosen)), is_per_corner)
    key = id(numbers), matrix.tobytes()
    if key not in moved:
        moved[key] = transform_normals(rows, matrix[:3, :3])
    return Column(moved[key], chosen, is_per_corner)


def read_texcoord(
    shape: PlacedNode, appearance: Appearance, corners: Corners, *, is_vrml1: bool, visit: Visit
) -> Column | None:
    """Return the texture coordinates of a face set, None if it has none. Raises MeshError if they do not fit it."""
    own = next(iter(shape.nodes("texCoord")), None)
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
    diffuse, emissive = material.table("diffuseColor", 3), material.table("emissiveColor", 3)
    found = (emissive if emissive.any() else diffuse, emissive) if is_line else (diffuse, emissive)
    table = next((rows for rows in found if len(rows)), np.array([_MATERIAL_COLOR]))
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
        return np.where(corners.is_corner, np.cumsum(corners.is_corner) - 1, -1)
    if binding in ("PER_FACE", "PER_PART"):
        return np.arange(corners.n_rows)
    raise MeshError(f"line {shape.line}: {shape.kind} has no meaning for {binding or 'OVERALL'}")


def _choose(shape: PlacedNode, index: str, corners: Corners, is_per_corner: bool) -> IndexArray:
    """Return which rows a shape has: those of its list `index`, else those of `coordIndex`, or one per face (6.23)."""
    numbers = shape.numbers(index)
    own = np.zeros(0, np.int64) if numbers is None else numbers.integers()
    budget().take_numbers(len(own), shape.line)
    if not is_per_corner:
        own = own[own >= 0]
        if len(own) == 0:
            return np.arange(corners.n_rows)
        if len(own) < corners.n_rows:
            raise MeshError(f"line {shape.line}: {index} has {len(own)} numbers for {corners.n_rows} faces")
        return own[: corners.n_rows]
    if not (own >= 0).any():
        return corners.values
    chosen = np.full(len(corners.values), -1)
    n_corners = int(corners.is_corner.sum())
    own = own[own >= 0]
    if len(own) < n_corners:
        raise MeshError(f"line {shape.line}: {index} has {len(own)} numbers for {n_corners} corners")
    chosen[corners.is_corner] = own[:n_corners]
    return chosen


def _rows_of(
    node: PlacedNode, name: str, width: int, chosen: IndexArray, is_per_corner: bool, corners: Corners
) -> Float64Array:
    """Return the rows of a field, all of which `chosen` must name."""
    rows = node.table(name, width)
    used = chosen[corners.is_corner] if is_per_corner else chosen
    if len(used) and (used.min() < 0 or used.max() >= len(rows)):
        raise MeshError(f"line {node.line}: {name} has {len(rows)} rows, its shape names row {used.max()}")
    return rows
