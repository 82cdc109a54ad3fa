"""Style overrides: what the keys of a viewer change of the models' own styles."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from ..compute.mesh_buffer import MeshBuffer
from ..drawing.build_layer import CLOUD_POINT_SIZE_PX
from ..drawing.enums import HIDDEN_STYLES, HiddenStyle
from ..drawing.layer import Layer, dot_diameter, with_lengths_in_pixels
from ..drawing.layer_colors import colors_by_face
from ..drawing.lengths import PX_PER_INCH
from ..geometry.edges import has_brep_faces, resolve_edges
from ..geometry.mesh import Mesh
from ..imaging.colors import ColorLike, to_rgba
from .key_bindings import EDGE_CYCLE

Value = TypeVar("Value")

OUTLINE = "silhouette"
DEFAULT_FILL = "lightgray"
LIGHT, DARK = "white", "#1e1e1e"  # backgrounds


@dataclass(frozen=True)
class StyleOverrides:
    """Values that replace those of all layers; None keeps the layers' own."""

    edges: str | None = None
    hidden: HiddenStyle | None = None
    filled: bool | None = None
    face_colors: bool | None = None
    antialias: bool | None = None
    background: ColorLike | None = None


def list_edge_sets(layer: Layer) -> tuple[str, ...]:
    """Return the sets of `EDGE_CYCLE` that have edges of a layer: a smooth closed surface has no sharp ones."""
    mesh = layer.model.mesh if isinstance(layer.model, MeshBuffer) else layer.model
    if not isinstance(mesh, Mesh):
        return EDGE_CYCLE
    return tuple(
        name
        for name in EDGE_CYCLE
        if name in ("all", OUTLINE) or len(resolve_edges(mesh, name, layer.feature_angle)) > 0
    )


def next_edges(
    overrides: StyleOverrides, layer: Layer, edge_sets: Sequence[Sequence[str]] = (EDGE_CYCLE,)
) -> tuple[StyleOverrides, str]:
    """Return overrides with the next set that has edges, and a note on it; `layer` has the first value.

    edge_sets : `list_edge_sets` of all layers
    """
    cycle = [name for name in EDGE_CYCLE if any(name in sets for sets in edge_sets)]
    edges = _next(_shown_edges(overrides, layer), cycle)
    return replace(overrides, edges=edges), f"edges: {edges}"


def next_hidden(overrides: StyleOverrides, layer: Layer) -> tuple[StyleOverrides, str]:
    """Return overrides with the next style of hidden edges, and a note on it."""
    default: HiddenStyle = "remove" if _is_filled(overrides, layer) else "show"
    given = "dash" if layer.hidden is None and layer.hidden_style is not None else layer.hidden
    hidden = _next(overrides.hidden or given or default, HIDDEN_STYLES)
    return replace(overrides, hidden=hidden), f"hidden edges: {hidden}"


def toggle_fill(overrides: StyleOverrides, layer: Layer) -> tuple[StyleOverrides, str]:
    """Return overrides with faces filled if they were not, and the reverse, and a note on it."""
    filled = not _is_filled(overrides, layer)
    return replace(overrides, filled=filled), f"faces filled: {_on_off(filled)}"


def toggle_face_colors(overrides: StyleOverrides, layer: Layer) -> tuple[StyleOverrides, str]:
    """Return overrides with one colour per face if there was one for all, and the reverse, and a note on it.

    The edges of faces have these colours if all edges are drawn; else the faces are filled.
    """
    colored = not _has_face_colors(overrides, layer)
    if colored and _shown_edges(overrides, layer) != "all":
        overrides = replace(overrides, filled=True)
    return replace(overrides, face_colors=colored), f"one colour per face: {_on_off(colored)}"


def toggle_antialias(overrides: StyleOverrides, layer: Layer) -> tuple[StyleOverrides, str]:
    """Return overrides with smooth lines if they were jagged, and the reverse, and a note on it."""
    smooth = not (layer.antialias if overrides.antialias is None else overrides.antialias)
    return replace(overrides, antialias=smooth), f"smooth lines: {_on_off(smooth)}"


def next_background(overrides: StyleOverrides, initial: ColorLike | None) -> tuple[StyleOverrides, str]:
    """Return overrides with the next of three backgrounds, `initial`, light and dark, and a note on it."""
    cycle = [initial, *(color for color in (LIGHT, DARK) if _as_rgba(color) != _as_rgba(initial))]
    current = _as_rgba(overrides.background or initial)
    index = next(i for i, color in enumerate(cycle) if _as_rgba(color) == current)
    background = cycle[(index + 1) % len(cycle)]
    name = background if isinstance(background, str) else "as at first"
    return replace(overrides, background=None if background is initial else background), f"background: {name}"


def apply_overrides(
    layers: Sequence[Layer],
    overrides: StyleOverrides,
    pixel_ratio: float,
    edge_sets: Sequence[Sequence[str]] | None = None,
) -> list[Layer]:
    """Return layers with their styles overridden, and with lines and points `pixel_ratio` times as wide.

    edge_sets : `list_edge_sets` of each layer; one that has no edges of a set shows its outline instead
    """
    in_pixels = [with_lengths_in_pixels(layer, PX_PER_INCH) for layer in layers]
    changed = []
    for layer, sets in zip(in_pixels, edge_sets or [EDGE_CYCLE] * len(layers), strict=True):
        is_shown = overrides.edges is None or overrides.edges in sets
        own = overrides if is_shown else replace(overrides, edges=OUTLINE)
        changed.append(replace(layer, **_changes(layer, own, pixel_ratio)))
    return changed


def has_faces(layer: Layer) -> bool:
    """Tell whether a layer has faces, to be filled and to tell edges by."""
    mesh = layer.model.topology if isinstance(layer.model, MeshBuffer) else layer.model
    return isinstance(mesh, Mesh) and mesh.n_faces > 0


def _changes(layer: Layer, overrides: StyleOverrides, pixel_ratio: float) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    if not isinstance(layer.line_width, str):
        changes["line_width"] = layer.line_width * pixel_ratio
    if layer.hidden_style is not None and "line_width" in layer.hidden_style:
        width = layer.hidden_style["line_width"] * pixel_ratio
        changes["hidden_style"] = {**layer.hidden_style, "line_width": width}
    size = dot_diameter(layer)
    if size is None and not has_faces(layer) and layer.edges is None:
        size = CLOUD_POINT_SIZE_PX
    if size is not None:
        changes["point_size"] = size * pixel_ratio
    if overrides.antialias is not None:
        changes["antialias"] = overrides.antialias
    if has_faces(layer):
        if overrides.hidden is not None:
            changes["hidden"] = overrides.hidden
            if overrides.hidden not in ("dash", "fade"):
                changes["hidden_style"] = None
        changes |= _face_changes(layer, overrides)
    color = changes.get("color", layer.color)
    is_unfilled = changes.get("fill", layer.fill) is None
    if overrides.background == DARK and is_unfilled and not _is_color_cycle(color):
        *hue, alpha = to_rgba(color, "color")
        if hue == [0.0, 0.0, 0.0]:
            changes["color"] = (LIGHT, alpha)
    return changes


def _face_changes(layer: Layer, overrides: StyleOverrides) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    if overrides.edges is not None:
        is_default = overrides.edges == "all" and not _has_brep_faces(layer)
        changes["edges"] = None if is_default else overrides.edges
        if _edge_set_name(layer.edges) is None:  # the colours were for the rows of an array
            changes["edge_colors"] = None
    cycle = "face" if layer.face_colors is None else layer.face_colors
    fill = layer.fill
    if overrides.filled is not None:
        fill = (fill if fill is not None else DEFAULT_FILL) if overrides.filled else None
    if fill is not None and overrides.face_colors is not None:
        if overrides.face_colors:
            fill = cycle
        elif _is_color_cycle(fill):
            fill = DEFAULT_FILL
    changes["fill"] = fill
    edges = changes.get("edges", layer.edges)
    if overrides.face_colors and fill is None and edges is None:
        changes |= {"edge_colors": None, "vertex_colors": None, "scalars": None}
        if layer.face_colors is None:
            changes["color"] = "face"
    elif colors_by_face(layer) and (
        overrides.face_colors is False or (overrides.edges is not None and edges is not None)
    ):
        changes["face_colors"] = None
        if _is_color_cycle(layer.color):
            changes["color"] = "black"
    return changes


def _has_brep_faces(layer: Layer) -> bool:
    return isinstance(layer.model, Mesh) and has_brep_faces(layer.model)


def _shown_edges(overrides: StyleOverrides, layer: Layer) -> str | None:
    return overrides.edges or _edge_set_name(layer.edges)


def _edge_set_name(edges: Any) -> str | None:
    """Return the name of a set of edges; None if there are several, or an array."""
    if edges is None:
        return "all"
    if isinstance(edges, Sequence) and not isinstance(edges, str) and len(edges) == 1:
        edges = edges[0]
    return edges if isinstance(edges, str) else None


def _is_filled(overrides: StyleOverrides, layer: Layer) -> bool:
    return layer.fill is not None if overrides.filled is None else overrides.filled


def _has_face_colors(overrides: StyleOverrides, layer: Layer) -> bool:
    if overrides.face_colors is not None:
        return overrides.face_colors
    return colors_by_face(layer) or _is_color_cycle(layer.fill)


def _is_color_cycle(color: Any) -> bool:
    return isinstance(color, str) and color == "face"  # an array would be compared element by element


def _as_rgba(background: ColorLike | None) -> Any:
    return None if background is None else to_rgba(background, "background")


def _next(value: Value | None, cycle: Sequence[Value]) -> Value:
    """Return what follows `value` in `cycle`, or the first if it is not there."""
    return cycle[(cycle.index(value) + 1) % len(cycle)] if value in cycle else cycle[0]


def _on_off(value: bool) -> str:
    return "on" if value else "off"
