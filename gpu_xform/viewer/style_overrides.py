"""How a viewer shows models: what keys change of their own style."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from ..drawing.build_draw_list import CLOUD_POINT_SIZE_PX
from ..drawing.enums import HIDDEN_STYLES, HiddenStyle
from ..drawing.layer import Layer
from ..drawing.layer_colors import colors_by_face
from ..geometry.edges import EDGE_SETS
from ..geometry.mesh import Mesh
from ..imaging.colors import ColorLike, rgba

Value = TypeVar("Value")

PAINT = "lightgray"
LIGHT, DARK = "white", "#1e1e1e"


@dataclass(frozen=True)
class Look:
    """What is not None goes for all models, in place of what their layers say."""

    edges: str | None = None
    hidden: HiddenStyle | None = None
    filled: bool | None = None
    by_face: bool | None = None
    antialias: bool | None = None
    ground: ColorLike | None = None


def next_edges(look: Look, layer: Layer) -> tuple[Look, str]:
    """Return the look with the next set of edges, and what to say of it; where there is no choice yet, `layer` has."""
    edges = _after(_edges(look, layer), EDGE_SETS)
    return replace(look, edges=edges), f"edges: {edges}"


def next_hidden(look: Look, layer: Layer) -> tuple[Look, str]:
    """Return the look with hidden edges drawn in the next way."""
    hidden = _after(look.hidden or layer.hidden or ("remove" if _filled(look, layer) else "show"), HIDDEN_STYLES)
    return replace(look, hidden=hidden), f"hidden edges: {hidden}"


def other_fill(look: Look, layer: Layer) -> tuple[Look, str]:
    """Return the look with faces painted where they were not."""
    filled = not _filled(look, layer)
    return replace(look, filled=filled), f"faces painted: {_on(filled)}"


def other_face_colors(look: Look, layer: Layer) -> tuple[Look, str]:
    """Return the look with a colour for each face where there was one for all.

    Outlines have them where all edges are drawn; of other edges, the faces have to be painted.
    """
    colored = not _colored(look, layer)
    if colored and _edges(look, layer) != "all":
        look = replace(look, filled=True)
    return replace(look, by_face=colored), f"a colour for each face: {_on(colored)}"


def other_antialias(look: Look, layer: Layer) -> tuple[Look, str]:
    """Return the look with lines smooth where they were rough."""
    smooth = not (layer.antialias if look.antialias is None else look.antialias)
    return replace(look, antialias=smooth), f"smooth lines: {_on(smooth)}"


def next_ground(look: Look, given: ColorLike | None) -> tuple[Look, str]:
    """Return the look on the next of three backgrounds: `given`, light, dark."""
    own = _shade(given)
    cycle = [given, *(ground for ground in (LIGHT, DARK) if _shade(ground) != own)]
    now = next(i for i, ground in enumerate(cycle) if _shade(ground) == _shade(look.ground or given))
    ground = cycle[(now + 1) % len(cycle)]
    name = ground if isinstance(ground, str) else "as at first"
    return replace(look, ground=None if ground is given else ground), f"background: {name}"


def restyled(layers: Sequence[Layer], look: Look, pixel_ratio: float) -> list[Layer]:
    """Return layers in this look; lines and dots are `pixel_ratio` times as wide."""
    return [replace(layer, **_changes(layer, look, pixel_ratio)) for layer in layers]


def has_faces(layer: Layer) -> bool:
    """Whether there are faces to paint and to tell edges by."""
    return isinstance(layer.model, Mesh) and layer.model.n_faces > 0


def _changes(layer: Layer, look: Look, pixel_ratio: float) -> dict[str, Any]:
    changes: dict[str, Any] = {"line_width": layer.line_width * pixel_ratio}
    size = layer.point_size
    if size is None and not has_faces(layer) and layer.edges is None:
        size = CLOUD_POINT_SIZE_PX
    if size is not None:
        changes["point_size"] = size * pixel_ratio
    if look.antialias is not None:
        changes["antialias"] = look.antialias
    if has_faces(layer):
        if look.hidden is not None:
            changes["hidden"] = look.hidden
        changes |= _face_changes(layer, look)
    color = changes.get("color", layer.color)
    is_on_ground = changes.get("fill", layer.fill) is None
    if look.ground == DARK and is_on_ground and not _is_face(color):
        *hue, alpha = rgba(color, "color")
        if hue == [0.0, 0.0, 0.0]:
            changes["color"] = (LIGHT, alpha)
    return changes


def _face_changes(layer: Layer, look: Look) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    if look.edges is not None:
        changes["edges"] = None if look.edges == "all" else look.edges
        if _name(layer.edges) is None:  # the colours were for the rows of an array
            changes["edge_colors"] = None
    cycle = "face" if layer.face_colors is None else layer.face_colors
    fill = layer.fill
    if look.filled is not None:
        fill = (fill if fill is not None else PAINT) if look.filled else None
    if fill is not None and look.by_face is not None:
        if look.by_face:
            fill = cycle
        elif _is_face(fill):
            fill = PAINT
    changes["fill"] = fill
    edges = changes.get("edges", layer.edges)
    if look.by_face and fill is None and edges is None:
        changes |= {"edge_colors": None, "vertex_colors": None, "scalars": None}
        if layer.face_colors is None:
            changes["color"] = "face"
    elif colors_by_face(layer) and (look.by_face is False or (look.edges is not None and edges is not None)):
        changes["face_colors"] = None
        if _is_face(layer.color):
            changes["color"] = "black"
    return changes


def _edges(look: Look, layer: Layer) -> str | None:
    return look.edges or _name(layer.edges)


def _name(edges: Any) -> str | None:
    """Return the one name of a set of edges, None where there are several or an array."""
    if edges is None:
        return "all"
    if isinstance(edges, Sequence) and not isinstance(edges, str) and len(edges) == 1:
        edges = edges[0]
    return edges if isinstance(edges, str) else None


def _filled(look: Look, layer: Layer) -> bool:
    return layer.fill is not None if look.filled is None else look.filled


def _colored(look: Look, layer: Layer) -> bool:
    if look.by_face is not None:
        return look.by_face
    return colors_by_face(layer) or _is_face(layer.fill)


def _is_face(color: Any) -> bool:
    return isinstance(color, str) and color == "face"  # an array would compare its numbers


def _shade(ground: ColorLike | None) -> Any:
    return None if ground is None else rgba(ground, "background")


def _after(value: Value | None, cycle: Sequence[Value]) -> Value:
    """Return what follows `value` in `cycle`; the first where it is not there."""
    return cycle[(cycle.index(value) + 1) % len(cycle)] if value in cycle else cycle[0]


def _on(value: bool) -> str:
    return "on" if value else "off"
