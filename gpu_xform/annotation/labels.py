"""Labels at points: where each text goes, so that no two overlap and none leaves the picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._core.types import Float64Array
from .boxes import TakenBoxes
from .items import Annotation, Box, Line, Text
from .text_style import TextStyle, move_text

MAX_LABELS = 5000  # of those in the picture, the nearest; more would have no room in any picture
_SIDES = np.array(
    [(np.cos(angle), -np.sin(angle)) for angle in np.deg2rad([45.0, 0.0, 90.0, 135.0, 315.0, 180.0, 270.0, 225.0])]
)  # around a point, the best first: the upper right, as cartographers place names
_GAPS = (0.25, 1.0, 2.0)  # between a point and its label, in sizes of the font
_MIN_LEADER_GAP = 0.5  # from there on a line leads from the point to its label
_GAP_BETWEEN_PX = 1.0
_LEADER_ALPHA = 0.6


@dataclass(frozen=True)
class Anchor:
    """A text and the point that it names.

    x, y : in pixels
    distance : from the eye; nearer points choose first
    radius : of what is drawn at the point
    outward : (2,), away from the model; (0, 0) if the text lies over the point, where there is room
    """

    text: Text
    x: float
    y: float
    distance: float
    radius: float
    outward: Float64Array
    is_centred: bool = False


def place_labels(
    anchors: Sequence[Anchor], taken: TakenBoxes, size: tuple[int, int], style: TextStyle
) -> tuple[Annotation, int]:
    """Return the labels at the places that they found, and the number of those that found none.

    The nearest points choose first: the side away from the model, then the others, then places farther off with a line
    that leads there. `taken` holds what the labels must not cover, and holds their boxes too afterwards.
    """
    texts: list[Text] = []
    leaders: list[Line] = []
    order = sorted(range(len(anchors)), key=lambda i: (anchors[i].distance, i))
    for i in order[:MAX_LABELS]:
        anchor = anchors[i]
        candidates, gaps = _list_candidates(anchor, size, style)
        found = taken.first_free(candidates) if len(candidates) else None
        if found is None:
            continue
        box = Box(*candidates[found].tolist()).widened(-_GAP_BETWEEN_PX)
        taken.add(box.widened(_GAP_BETWEEN_PX))
        texts.append(move_text(anchor.text, box.left, box.top))
        if gaps[found] >= _MIN_LEADER_GAP:
            leaders.append(_lead(anchor, box, style))
    return Annotation(leaders, texts), len(anchors) - len(texts)


def _list_candidates(anchor: Anchor, size: tuple[int, int], style: TextStyle) -> tuple[Float64Array, Float64Array]:
    """Return the boxes (c, 4) in which a label may lie, the best first, and their gaps (c,) from the point."""
    left, top, right, bottom = anchor.text.box
    half = 0.5 * np.array((right - left, bottom - top)) + _GAP_BETWEEN_PX
    sides = _SIDES
    length = float(np.hypot(*anchor.outward))
    if length > 0.0:
        # Rounded, so that of sides that are equally good, the first of the list is the better one everywhere.
        sides = _SIDES[np.argsort(-np.round(_SIDES @ (anchor.outward / length), 3), kind="stable")]
    gaps = np.repeat(_GAPS, len(sides)) * style.size
    directions = np.tile(sides, (len(_GAPS), 1))
    # As far out as makes the box touch a circle around the point: its corner or its side.
    reach = (anchor.radius + gaps)[:, np.newaxis] * directions
    centers = (anchor.x, anchor.y) + reach + half * np.sign(np.round(directions, 6))
    used = gaps / style.size
    if anchor.is_centred:
        centers, used = np.concatenate([[(anchor.x, anchor.y)], centers]), np.concatenate([[0.0], used])
    boxes = np.column_stack([centers - half, centers + half])
    is_inside = (boxes[:, :2] >= 0.0).all(axis=1) & (boxes[:, 2:] <= size).all(axis=1)
    return boxes[is_inside], used[is_inside]


def _lead(anchor: Anchor, box: Box, style: TextStyle) -> Line:
    """Return the line from a point to the nearest point of the box of its label."""
    x = min(max(anchor.x, box.left), box.right)
    y = min(max(anchor.y, box.top), box.bottom)
    *rgb, alpha = anchor.text.color
    color = (rgb[0], rgb[1], rgb[2], alpha * _LEADER_ALPHA)
    return Line(anchor.x, anchor.y, x, y, max(0.75, 0.05 * style.size), color)
