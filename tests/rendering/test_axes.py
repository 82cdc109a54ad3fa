"""Axes, legends and colour bars in pictures: the model is drawn smaller, and they are around it."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pypdfium2
import pytest

import gpu_xform as gx
from gpu_xform.annotation.options import AnnotationOptions
from gpu_xform.drawing.layer import Style
from gpu_xform.drawing.prepare import Frame, PreparedFrame, prepare_frame
from gpu_xform.errors import ArgumentError, ArgumentTypeError

SIZE = (200, 150)
CUBE = gx.samples.cube()


def prepare(models: Any, camera: Any = None, options: Any = None, **style: Any) -> PreparedFrame:
    frame = Frame(camera, SIZE, annotations=AnnotationOptions(**(options or {"axes": True})))
    with prepare_frame(models, frame, cast("Style", style)) as prepared:
        return prepared


def test_every_text_lies_in_the_picture_and_the_models_in_the_frame() -> None:
    for camera in (None, {"direction": (0, 0, -1)}, {"orthographic": True}, gx.Camera.look_at((4, 3, 9), (0, 0, 0))):
        prepared = prepare(CUBE, camera)
        for text in prepared.annotation.texts:
            assert min(text.box.left, text.box.top) >= 0.0
            assert text.box.right <= SIZE[0]
            assert text.box.bottom <= SIZE[1]
        clip = CUBE.positions @ prepared.view.clip_from_world[:, :3].T + prepared.view.clip_from_world[:, 3]
        assert (np.abs(clip[:, :2]) < clip[:, 3:]).all()


def test_a_chart_whose_window_ends_where_its_line_does_has_numbers_on_both_axes() -> None:
    line = gx.Mesh([(0.0, -0.1, 0.0), (0.5, 0.1, 0.0), (1.0, 0.0, 0.0)], [(0, 1), (1, 2)])
    prepared = prepare(line, gx.Camera.window((0, 1), (-0.15, 0.15)), {"axes": ("t", "x", None)})
    *numbers, t, x = [text.text for text in prepared.annotation.texts]
    assert (t, x) == ("t", "x")
    assert {-0.1, 0.0, 0.1, 1.0} <= set(map(float, numbers))


def test_a_picture_with_axes_is_the_same_picture_made_smaller() -> None:
    camera = gx.Camera.look_at((4, 3, 9), (0, 0, 0), near=1.0, far=50.0)
    plain, framed = prepare(CUBE, camera, {"font_size": 9.0}), prepare(CUBE, camera)
    ends = []
    for prepared in (plain, framed):
        clip = CUBE.positions @ prepared.view.clip_from_world[:, :3].T + prepared.view.clip_from_world[:, 3]
        ends.append(clip[:, :2] / clip[:, 3:])
    shift = np.polyfit(ends[0][:, 0], ends[1][:, 0], 1), np.polyfit(ends[0][:, 1], ends[1][:, 1], 1)
    for axis, (scale, offset) in enumerate(shift):
        np.testing.assert_allclose(ends[1][:, axis], scale * ends[0][:, axis] + offset, atol=1e-12)
        assert 0.3 < scale <= 1.0 + 1e-9


def test_filled_faces_hide_the_grid_and_lines_lie_over_it() -> None:
    style: dict[str, Any] = {"size": SIZE, "axes": True, "fill": (1.0, 0.0, 0.0), "alpha": 1.0, "edges": "silhouette"}
    pixels = gx.render_array(CUBE, **style)
    red = (pixels[..., :3] == (255, 0, 0)).all(axis=2)
    assert red.sum() > 1500
    rows = np.flatnonzero(red.any(axis=1))
    middle = red[(rows[0] + rows[-1]) // 2]
    columns = np.flatnonzero(middle)
    assert middle[columns[0] : columns[-1] + 1].mean() > 0.95  # no grid line crosses


def test_texts_are_dark_on_light_and_light_on_dark() -> None:
    light, dark = (gx.render_array(CUBE, size=SIZE, axes=True, alpha=0.0, background=b) for b in ("white", "black"))
    assert light[..., :3].min() < 60
    assert dark[..., :3].max() > 190
    assert dark[..., :3].mean() < 40
    assert light[..., :3].mean() > 220


@pytest.mark.parametrize(
    ("options", "texts"),
    [
        ({"legend": True}, ["one", "two"]),
        ({"legend": ["first", None]}, ["first"]),
        ({"axes": (None, "height", None)}, ["height"]),
    ],
)
def test_what_pictures_may_be_annotated_with(options: Any, texts: list[str]) -> None:
    layers = [gx.Layer(CUBE, name="one", fill="gold"), gx.Layer(CUBE.positions, name="two", color="red")]
    written = [text.text for text in prepare(layers, options=options).annotation.texts]
    assert [text for text in written if not text.lstrip("-").replace(".", "").isdigit()] == texts


@pytest.mark.parametrize(
    ("scalars", "title"), [("y", "y"), (CUBE.positions[:, 1], ""), ("speed", "speed"), ("load", "load")]
)
def test_a_colour_bar_has_the_name_and_the_limits_of_its_numbers(scalars: Any, title: str) -> None:
    attributes = {"point": {"speed": np.linspace(-1, 1, 8)}, "face": {"load": np.linspace(-1, 1, 6)}}
    mesh = gx.Mesh(CUBE.positions, list(CUBE.faces), attributes=gx.Attributes(**attributes))
    annotation = prepare(mesh, scalars=scalars, colorbar=True, options={"font_size": 8}).annotation
    texts = [text.text for text in annotation.texts]
    assert ([title] if title else []) == [text for text in texts if text[-1].isalpha()]
    numbers = [float(text) for text in texts if not text[-1].isalpha()]
    assert (numbers[0], numbers[-1]) == (-1.0, 1.0)


def test_lines_of_intersection_are_no_models_of_a_legend_and_have_no_labels() -> None:
    both = [
        gx.Layer(CUBE, name="a", edges=["all", "intersection"], labels="indices", scalars="y", colorbar=True),
        gx.Layer(CUBE, name="b", transform=gx.translate(1, 0.5, 0.3)),
    ]
    prepared = prepare(both, options={"legend": ["A", "B"], "font_size": 5})
    assert [layer.labels is None for layer in prepared.layers] == [False, True, True]
    assert [text.text for text in prepared.annotation.texts][:2] == ["A", "B"]


@pytest.mark.parametrize(("legend", "name"), [(["b"], "b"), (True, "box")])
def test_the_parts_of_a_section_are_one_model_of_a_legend_and_have_one_colour_bar(legend: Any, name: str) -> None:
    style: dict[str, Any] = {"section": ((0, 0, 0), (0, 0, 1)), "scalars": "y", "colorbar": True, "name": "box"}
    prepared = prepare(CUBE, options={"legend": legend, "font_size": 5}, **style)
    texts = [text.text for text in prepared.annotation.texts if text.text[-1].isalpha()]
    assert texts == [name, "y"]


def test_layers_share_a_colour_bar_if_it_is_the_same() -> None:
    def bars(**other: Any) -> int:
        first = gx.Layer(CUBE, scalars="y", colorbar="h", clim=(0, 1))
        second = gx.Layer(CUBE, **{"scalars": "y", "colorbar": "h", "clim": (0, 1)} | other)
        return [text.text for text in prepare([first, second], options={"font_size": 6}).annotation.texts].count("h")

    assert bars() == 1
    assert bars(clim=(0, 2)) == bars(cmap="plasma") == 2


def test_axes_stand_still_in_an_animation() -> None:
    film = gx.animate(CUBE, [gx.translate(x, 0, 0) for x in (0.0, 3.0)], size=SIZE, axes=True, color="red", alpha=0.0)
    first, second = (np.asarray(frame) for frame in film)
    assert (first[..., :3].min(axis=2) < 100).sum() > 100
    assert np.array_equal(first, second)
    texts = gx.render_svg(CUBE, axes=True, size=SIZE)
    assert texts.count("<text") > 9
    assert film[1:]._axes_bounds is not None


def test_svg_and_pdf_have_axes_legend_and_colour_bar_as_text() -> None:
    style: dict[str, Any] = {"size": (320, 240), "axes": ("east", "up", "north"), "legend": True, "name": "a cube"}
    style |= {"scalars": "y", "colorbar": "height", "font_size": 9}
    svg = gx.render_svg(CUBE, **style)
    [page] = pypdfium2.PdfDocument(gx.render_pdf(CUBE, **style))
    found = page.get_textpage().get_text_range()
    for text in ("east", "up", "north", "a cube", "height", "-1.0", "0.5"):
        assert f">{text}</text>" in svg
        assert text in found
    assert 'id="grid"' in svg
    pixels = gx.render_array(CUBE, **style)[..., :3].astype(int)
    printed = page.render(scale=96 / 72).to_numpy()[..., [2, 1, 0]].astype(int)
    assert np.abs(pixels - printed).mean() < 2.5


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"axes": "xyz"}, ArgumentTypeError, "^axes must be True, False or three titles, got 'xyz'$"),
    ({"axes": ["x", "y"]}, ArgumentError, "^axes must have three titles, got 2$"),
    ({"axes": ["x", "y", 5]}, ArgumentTypeError, r"^axes\[2\] must be a text, got 5$"),
    (
        {"legend": True},
        ArgumentError,
        "^legend must come with models that have names, or be a text per model, got none",
    ),
    ({"legend": ["a", "b"]}, ArgumentError, "^legend must have one text for each of the 1 models, got 2$"),
    ({"legend": 1}, ArgumentTypeError, "^legend must be True, False or a text per model, got 1$"),
    ({"colorbar": True}, ArgumentError, "^colorbar must come with scalars: there are no numbers to explain$"),
    ({"colorbar": 5}, ArgumentTypeError, "^colorbar must be True, False or a title, got 5$"),
]


@pytest.mark.parametrize(("options", "error", "message"), BAD)
def test_impossible_annotations_are_errors(options: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        gx.render(CUBE, size=(64, 64), **options)
    with pytest.raises(error, match=message):
        gx.animate(CUBE, [np.eye(4)], size=(64, 64), **options)[0]


def test_a_legend_of_models_that_look_alike_is_refused() -> None:
    models = [gx.Layer(CUBE, name=name) for name in ("one", "two")]
    with pytest.raises(ArgumentError, match="legend must tell the models apart: all 2 look alike"):
        gx.render_svg(models, legend=True, size=(64, 48))
    assert ">two</text>" in gx.render_svg([models[0], replace(models[1], color="red")], legend=True, size=(180, 90))
