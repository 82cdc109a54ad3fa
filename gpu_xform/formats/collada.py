"""COLLADA (`.dae`), through lxml: triangles in metres, with the axes of the file."""

from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import require_affine
from ..errors import ArgumentError, MeshError
from ..geometry.mesh import Mesh
from ._text import quote
from ._warn import warn
from ._xml import parse_xml
from .collada_geometries import Group, first_child, read_groups
from .collada_materials import find_effect, read_color
from .collada_nodes import Shape, place_shapes
from .collada_placing import Part, place_parts
from .limits import budget

_MAX_NAMED = 4
_TRIANGLE_NUMBERS = 12  # with three points; a part with less counts as one


def read(data: bytes) -> Mesh:
    """Return all triangles where the nodes of the scene put them, in the colours of their materials.

    Raises MeshError for a damaged file, MissingExtraError if the extra `robots` is not installed.
    """
    root = parse_xml(data, "COLLADA")
    placed = place_shapes(root)
    library = _Library(root, placed.lost)
    shapes: list[list[Part]] = []
    n_shown = np.bincount(placed.shape_numbers, minlength=len(placed.shapes))
    for shape, n_places in zip(placed.shapes, n_shown.tolist(), strict=True):
        shapes.append(library.list_parts(shape))
        budget().take_numbers(
            n_places * sum(max(part.n_numbers, _TRIANGLE_NUMBERS) for part, _ in shapes[-1]), "its nodes"
        )
    if not any(shapes):
        raise MeshError("it shows no triangles" + (f", read without {library.lost[0]}" if library.lost else ""))
    if library.lost:
        more = ", ..." if len(library.lost) > _MAX_NAMED else ""
        warn(f"it is read without {', '.join(library.lost[:_MAX_NAMED])}{more}")
    with np.errstate(over="ignore", invalid="ignore"):
        matrices = np.diag([*[_read_metres(root)] * 3, 1.0]) @ placed.matrices
    shown = matrices[np.unique(placed.matrix_numbers)]
    if not np.isfinite(shown).all():
        raise MeshError("the matrix of a node is not finite")
    try:
        require_affine(shown, "the matrix")
    except ArgumentError as error:
        raise MeshError(f"a node: {error}") from None
    return place_parts(shapes, placed.shape_numbers, matrices, placed.matrix_numbers)


class _Library:
    """The geometries, materials and effects of a file, each read when it is first shown."""

    def __init__(self, root: Any, lost: list[str]) -> None:
        self._geometries = _collect(root, "library_geometries", "geometry")
        self._materials = _collect(root, "library_materials", "material")
        self._effects = _collect(root, "library_effects", "effect")
        self._groups: dict[str, list[Group]] = {}
        self._colors: dict[str, npt.NDArray[np.uint8] | None] = {}
        self._effect_colors: dict[Any, npt.NDArray[np.uint8] | MeshError] = {}
        self.lost = lost  # what is left out, in words

    def list_parts(self, shape: Shape) -> list[Part]:
        """Return the parts of a geometry, in the materials that an instance of it binds."""
        url, bindings = shape
        colors = {symbol: self._read_color(target) for symbol, target in bindings}
        found = ((group, colors.get(group.material)) for group in self._read_groups(url))
        return [(group.bare if color is None else group.colored_by_material, color) for group, color in found]

    def _read_groups(self, url: str) -> list[Group]:
        if url not in self._groups:
            try:
                self._groups[url] = read_groups(_look_up(self._geometries, url))
            except MeshError as error:
                self.lost.append(f"geometry {quote(url)} ({error})")
                self._groups[url] = []
        return self._groups[url]

    def _read_color(self, url: str) -> npt.NDArray[np.uint8] | None:
        if url not in self._colors:
            try:
                self._colors[url] = self._read_effect(find_effect(_look_up(self._materials, url), self._effects))
            except MeshError as error:
                self.lost.append(f"material {quote(url)} ({error})")
                self._colors[url] = None
        return self._colors[url]

    def _read_effect(self, effect: Any) -> npt.NDArray[np.uint8]:
        """Return the colour of an effect, which is read once for all materials that share it."""
        if effect not in self._effect_colors:
            try:
                self._effect_colors[effect] = read_color(effect)
            except MeshError as error:
                self._effect_colors[effect] = error
        found = self._effect_colors[effect]
        if isinstance(found, MeshError):
            raise found
        return found


def _collect(root: Any, library: str, tag: str) -> dict[str | None, Any]:
    """Return the elements of all libraries of a kind by their identifiers."""
    libraries = root.iterchildren(f"{{*}}{library}")
    return {each.get("id"): each for found in libraries for each in found.iterchildren(f"{{*}}{tag}")}


def _look_up(elements: dict[str | None, Any], url: str) -> Any:
    if not url.startswith("#") or url[1:] not in elements:
        raise MeshError("it is not there")
    return elements[url[1:]]


def _read_metres(root: Any) -> float:
    """Return how many metres the unit of a file is."""
    asset = first_child(root, "asset")
    unit = None if asset is None else first_child(asset, "unit")
    try:
        return 1.0 if unit is None else float(unit.get("meter")) or 1.0
    except (TypeError, ValueError):
        return 1.0
