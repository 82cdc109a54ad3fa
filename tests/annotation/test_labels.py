"""Labels find places in the picture that no other label has."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.annotation.boxes import TakenBoxes
from gpu_xform.annotation.items import Annotation, Box
from gpu_xform.annotation.labels import Anchor, place_labels
from gpu_xform.annotation.text_style import TextStyle, make_text_style

SIZE = (160, 120)
STYLE: TextStyle = make_text_style(None, 10.0, SIZE, (1.0, 1.0, 1.0, 1.0))


def overlaps(a: Box, b: Box) -> bool:
    return a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom


def anchor(x: float, y: float, text: str = "A1", **others: float) -> Anchor:
    outward = np.array([others.get("out_x", 0.0), others.get("out_y", 0.0)])
    return Anchor(
        STYLE.text(text, "labels"), x, y, others.get("distance", 0.0), others.get("radius", 1.0), outward, False
    )


def place(anchors: list[Anchor], taken: TakenBoxes | None = None) -> tuple[Annotation, int]:
    return place_labels(anchors, taken or TakenBoxes(), SIZE, STYLE)


coordinates = st.tuples(st.floats(0.0, SIZE[0]), st.floats(0.0, SIZE[1]))


@given(st.lists(st.tuples(coordinates, st.sampled_from(["a", "point 17", "gy"]), st.integers(0, 3)), max_size=40))
def test_no_two_labels_overlap_and_none_leaves_the_picture(rows: list[tuple[tuple[float, float], str, int]]) -> None:
    anchors = [anchor(x, y, text, distance=distance) for (x, y), text, distance in rows]
    obstacle = Box(60.0, 40.0, 100.0, 80.0)
    labels, n_without = place(anchors, TakenBoxes([obstacle]))
    boxes = [text.box for text in labels.texts]
    assert len(boxes) + n_without == len(rows)
    for i, box in enumerate(boxes):
        assert not overlaps(box, obstacle)
        assert min(box.left, box.top) >= 0.0
        assert box.right <= SIZE[0]
        assert box.bottom <= SIZE[1]
        assert not any(overlaps(box, other) for other in boxes[:i])
    again, _ = place(anchors, TakenBoxes([obstacle]))
    assert again == labels


@pytest.mark.parametrize(("out", "side"), [((1, 0), "right"), ((-1, 0), "left"), ((0, 1), "below"), ((0, -1), "above")])
def test_a_label_lies_on_the_side_away_from_its_model(out: tuple[int, int], side: str) -> None:
    labels, _ = place([anchor(80.0, 60.0, out_x=7.0 * out[0], out_y=7.0 * out[1], radius=3.0)])
    [text] = labels.texts
    gap = {
        "right": text.box.left - 80.0,
        "left": 80.0 - text.box.right,
        "below": text.box.top - 60.0,
        "above": 60.0 - text.box.bottom,
    }[side]
    assert gap == pytest.approx(3.0 + 0.25 * STYLE.size + 1.0)  # the dot, a quarter of the font, and a pixel around all


def test_the_nearest_point_chooses_first_and_others_are_led_to() -> None:
    crowd = [anchor(80.0, 60.0, f"n{i}", distance=float(-i)) for i in range(9)]
    labels, n_without = place(crowd)
    assert n_without == 0
    assert labels.texts[0].text == "n8"
    assert 1 <= len(labels.shapes) <= 5  # beyond the eight places that touch the point
    alone, _ = place([crowd[8]])
    assert labels.texts[0] == alone.texts[0]


def test_a_text_is_one_line() -> None:
    assert STYLE.text(" two\n lines ", "labels").text == "two lines"
