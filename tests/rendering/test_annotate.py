"""Labels in pictures: at their points, in pixels, SVG and PDF alike."""

import html
import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pypdfium2
import pytest

import gpu_xform as gx
from gpu_xform.annotation.items import Annotation, Box, Text
from gpu_xform.drawing.layer import Style
from gpu_xform.drawing.prepare import Frame, prepare_frame
from gpu_xform.errors import ArgumentError, ArgumentTypeError, TextWarning
from gpu_xform.rendering.annotate import make_annotation
from tests.support.browser import Browser
from tests.support.projection import world_to_pixels

SIZE = (180, 140)
CAMERA = gx.Camera.look_at((3, 2.2, 6), (0, 0.1, 0))
CUBE = gx.samples.cube()
LETTERS = list("ABCDEFGH")
HIDDEN_CORNER = int(CUBE.positions.sum(axis=1).argmin())  # the one away from the eye


def annotation_of(models: Any, camera: Any = CAMERA, **style: Any) -> Annotation:
    with prepare_frame(models, Frame(camera, SIZE), cast("Style", style)) as prepared:
        return make_annotation(prepared)


def texts_of(models: Any, **style: Any) -> dict[str, Text]:
    return {text.text: text for text in annotation_of(models, **style).texts}


def distance(box: Box, point: Any) -> float:
    x, y = point
    return float(np.hypot(max(box.left - x, 0, x - box.right), max(box.top - y, 0, y - box.bottom)))


def test_each_label_is_beside_its_own_point() -> None:
    texts = texts_of(CUBE, labels=LETTERS)
    pixels = world_to_pixels(CUBE.positions, CAMERA, SIZE)
    assert sorted(texts) == LETTERS
    for letter, point in zip(LETTERS, pixels, strict=True):
        assert distance(texts[letter].box, point) < 6.0
        others = [other for other in pixels if (other != point).any()]
        assert min(distance(texts[letter].box, other) for other in others) > 6.0


@pytest.mark.parametrize(
    ("hidden", "left_out", "faded"), [("show", 0, 0), ("remove", 1, 0), ("fade", 0, 1), ("dash", 0, 1)]
)
def test_labels_of_hidden_points_share_the_fate_of_hidden_lines(hidden: Any, left_out: int, faded: int) -> None:
    texts = texts_of(CUBE, labels=LETTERS, hidden=hidden)
    assert len(texts) == 8 - left_out
    pale = [letter for letter, text in texts.items() if text.color[3] < 1.0]
    assert len(pale) == faded
    if left_out or faded:
        assert set(LETTERS) - texts.keys() | set(pale) == {LETTERS[HIDDEN_CORNER]}


def test_faces_of_other_models_hide_labels() -> None:
    wall = gx.Layer(gx.Mesh([(-9, -9, 3), (9, -9, 3), (9, 9, 3), (-9, 9, 3)], [(0, 1, 2, 3)]), fill="white")
    points = gx.Layer(np.array([(0.0, 0, 0), (0.7, 0.5, 3.5)]), labels=["behind", "before"], hidden="remove")
    assert set(texts_of([points, wall])) == {"before"}
    # As dots: opaque faces of others hide them unless the layer says otherwise, the wall beside a body as well.
    points = replace(points, hidden=None)
    body = gx.Layer(CUBE, transform=gx.translate(0, -40, 0), hidden="remove")
    assert set(texts_of([points, wall])) == set(texts_of([points, body, wall])) == {"before"}
    for models in ([replace(points, hidden="show"), wall], [points, replace(wall, alpha=0.5)]):
        assert set(texts_of(models)) == {"before", "behind"}


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        ("indices", set("01234567")),
        (["a", None, "", "b", " ", "c", None, None], {"a", "b", "c"}),
        ({0: "first", -1: "last"}, {"first", "last"}),
        ({(0, 0, 0): "middle", 3: "corner"}, {"middle", "corner"}),
        (np.array(LETTERS), set(LETTERS)),
        ("names", {"a cube"}),
    ],
)
def test_what_labels_may_be(labels: Any, expected: set[str]) -> None:
    assert set(texts_of(CUBE, labels=labels, name="a cube")) == expected


def test_a_label_at_a_point_of_the_model_moves_with_its_instances() -> None:
    places = np.stack([gx.translate(-1, 0, 0), gx.translate(1, 0.3, 0)]) @ gx.scale(0.3)
    found = annotation_of(CUBE, labels={(1.0, 1.0, 1.0): "P"}, transform=places).texts
    pixels = world_to_pixels(gx.transform_points(np.ones((1, 3)), places)[:, 0], CAMERA, SIZE)
    assert len(found) == 2
    for point in pixels:
        assert min(distance(text.box, point) for text in found) < 6.0


def test_the_nodes_of_a_scene_are_named_once_each() -> None:
    scene = gx.Scene()
    scene.add(CUBE, name="left", transform=gx.translate(-1, 0, 0) @ gx.scale(0.2))
    both = scene.add(CUBE, name="right", transform=gx.translate(1, 0, 0) @ gx.scale(0.2))
    scene.add(CUBE, name="larger", parent=both, transform=gx.scale(2), color="red")
    texts = texts_of(scene, labels="names")
    assert set(texts) == {"left", "right", "larger"}
    for name, x in (("left", -1.0), ("right", 1.0)):
        point = world_to_pixels(np.array([(x, 0.0, 0.0)]), CAMERA, SIZE)[0]
        assert distance(texts[name].box, point) < 12.0
    assert texts["larger"].color[:3] == (1.0, 0.0, 0.0)
    assert texts["left"].color[:3] == pytest.approx((0.13, 0.13, 0.13))  # not black as the lines
    named = texts_of(gx.samples.robot_arm(), camera=None, labels="names")
    assert set(named) == {"base", "upper arm", "forearm", "hand"}


def test_points_on_the_device_and_of_clouds_have_labels() -> None:
    with gx.PointBuffer(CUBE.positions.astype(np.float32)) as buffer, gx.MeshBuffer(CUBE) as mesh:
        for model in (buffer, mesh, CUBE.positions):
            assert set(texts_of(model, labels=LETTERS)) == set(LETTERS)


@pytest.mark.parametrize(
    ("labels", "expected"),
    [(LETTERS, set("ABDEFGH")), ({2: "hidden", 3: "fourth", -1: "last", (0, 0, 0): "O"}, {"fourth", "last", "O"})],
)
def test_points_that_a_mask_hides_have_no_labels(labels: Any, expected: set[str]) -> None:
    points = np.ma.array(CUBE.positions, mask=np.zeros((8, 3), np.bool_))
    points[2] = np.ma.masked
    texts = texts_of(points, labels=labels)
    assert set(texts) == expected
    for letter in set(texts) & {"D", "fourth"}:
        assert distance(texts[letter].box, world_to_pixels(CUBE.positions[3:4], CAMERA, SIZE)[0]) < 6.0


def test_labels_that_find_no_room_are_counted() -> None:
    crowd = np.random.default_rng(0).normal(scale=0.1, size=(400, 3))
    with pytest.warns(TextWarning, match=r"^\d+ of 400 labels have no room: a larger picture or a smaller font_size"):
        texts = texts_of(crowd, labels="indices")
    assert 10 < len(texts) < 390


def test_a_text_beside_no_point_of_the_picture_is_left_out_and_costs_nothing() -> None:
    assert annotation_of(CUBE, labels={(500.0, 0, 0): "far", (0, 0, 900.0): "behind the eye"}).is_empty
    assert annotation_of(CUBE).is_empty


BAD_LABELS: list[tuple[Any, type[Exception], str]] = [
    ("indexes", ArgumentError, "^labels must be 'names', 'indices', a text .* got 'indexes'; did you mean 'indices'"),
    (
        5,
        ArgumentTypeError,
        "^labels must be 'names', 'indices', a text per point, or a dict from points to texts, got int",
    ),
    (["a"], ArgumentError, "^labels must have one text for each of the 8 points, got 1$"),
    ([1] * 8, ArgumentTypeError, r"^labels\[0\] must be a text, got 1$"),
    ({8: "a"}, ArgumentError, "^labels must name points below 8, got 8$"),
    ({"a": "a"}, ArgumentTypeError, "^a key of labels, if it is no point .* must be a whole number, got 'a'$"),
    ({(1, 2): "a"}, ArgumentError, r"^a key of labels must have shape \(3,\), got \(2,\)$"),
    ({0: 5}, ArgumentTypeError, r"^labels\[0\] must be a text, got 5$"),
]


@pytest.mark.parametrize(("labels", "error", "message"), BAD_LABELS)
def test_impossible_labels_are_errors(labels: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        gx.render(CUBE, labels=labels, size=(32, 32))


@pytest.mark.parametrize("options", [{"font": "no such font"}, {"font_size": 0}, {"font_size": 1e9}])
def test_impossible_fonts_are_errors_even_without_text(options: Any) -> None:
    for draw in (gx.render, gx.render_svg, gx.render_pdf):
        with pytest.raises(ArgumentError, match=r"^font(_size)? must"):
            draw(CUBE, size=(32, 32), **options)


def ink(pixels: Any, box: Box) -> Any:
    """Return the part of a picture around a box, as darkness from 0 to 1."""
    left, top, right, bottom = (round(side) for side in box.widened(2.0))
    return 1.0 - pixels[max(top, 0) : bottom, max(left, 0) : right, :3].mean(axis=2) / 255.0


def test_png_svg_and_pdf_have_the_same_texts_at_the_same_places(browser: Browser, tmp_path: Path) -> None:
    points = np.array([(0.0, 0.2, 0.0), (-0.9, -0.6, 0.0), (0.6, -0.9, 0.5)])
    names = ["first", "20 µm", "<A & B>"]
    style: Any = {"labels": names, "camera": CAMERA, "size": SIZE, "font_size": 16.0, "alpha": 0.0}
    texts = texts_of(points, labels=names, alpha=0.0)
    with prepare_frame(points, Frame(CAMERA, SIZE), {"labels": names, "alpha": 0.0}) as prepared:
        assert make_annotation(prepared).texts == tuple(texts.values())  # the same each time
    svg = gx.render_svg(points, **style)
    (tmp_path / "picture.svg").write_text(svg, "utf-8")
    browser.open(tmp_path / "picture.svg", SIZE)
    assert browser.evaluate("[...document.querySelectorAll('text')].map(text => text.textContent).sort()") == sorted(
        names
    )
    assert browser.console_messages() == []
    boxes = browser.evaluate(
        "[...document.querySelectorAll('text')].map(text => [text.textContent, text.getBoundingClientRect().left,"
        " text.getBoundingClientRect().right])"
    )
    [page] = pypdfium2.PdfDocument(gx.render_pdf(points, **style))
    found = page.get_textpage().get_text_range()
    assert all(name in found for name in names)
    png, shown = gx.render_array(points, **style), browser.screenshot()
    printed = page.render(scale=96 / 72).to_numpy()[..., [2, 1, 0]]
    places = re.findall(r'<text x="([\d.]+)" y="([\d.]+)".*? textLength="([\d.]+)".*?>(.*?)</text>', svg)
    assert len(places) == 3
    for x, y, width, escaped in places:
        name = html.unescape(escaped)
        left, right = next((left, right) for text, left, right in boxes if text == name)
        assert left == pytest.approx(float(x), abs=0.6)
        assert right == pytest.approx(float(x) + float(width), abs=0.6)
        box = Box(float(x), float(y) - 12.0, float(x) + float(width), float(y) + 4.0)
        first, second, third = (ink(picture, box) for picture in (png, shown, printed))
        for other in (second, third):
            for axis in (0, 1):  # the centre of the ink, within half a pixel
                index = np.arange(first.shape[axis])
                centers = [(each.sum(axis=1 - axis) * index).sum() / each.sum() for each in (first, other)]
                assert abs(centers[0] - centers[1]) < 1.0
            assert other.sum() == pytest.approx(first.sum(), rel=0.35)


def test_labels_follow_moving_points() -> None:
    film = gx.animate(CUBE, [gx.translate(x, 0, 0) for x in (-0.5, 0.5)], size=(96, 80), labels={0: "O"}, alpha=0.0)
    columns = [np.nonzero(np.asarray(frame)[..., 0] < 128)[1].mean() for frame in film]
    assert columns[1] - columns[0] > 8.0


def test_a_picture_without_text_does_not_warn() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gx.render(CUBE, size=(32, 32), font_size=9)
