"""What notebooks show of models, cameras and SVG documents."""

import io
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform._core.pictured import show_lists
from gpu_xform.rendering import preview

CUBE = gx.samples.cube()
LECTURE = (gx.Camera.eye_on_z(8, (-2, 2), (-2, 2)), gx.Camera.window((-1, 1), (-2, 2)))
CAMERA = gx.Camera.look_at((3, 2, 5), (0, 0, 0), near=1, far=10)


def scene() -> gx.Scene:
    tree = gx.Scene()
    tree.add(CUBE, name="cube")
    return tree


def picture_of(thing: Any) -> np.ndarray[Any, Any]:
    with Image.open(io.BytesIO(thing._repr_png_())) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB"))


@pytest.mark.parametrize("thing", [CUBE, scene(), gx.Layer(CUBE, color="red"), CAMERA, *LECTURE], ids=repr)
def test_models_and_cameras_show_a_small_picture(thing: Any) -> None:
    shown = picture_of(thing)
    assert shown.shape == (*preview.SIZE[::-1], 3)
    assert len(thing._repr_png_()) < 100_000
    assert 0.002 < (shown != 255).any(axis=2).mean() < 0.5


def test_a_mesh_is_shown_as_render_shows_it_and_a_layer_in_its_own_style() -> None:
    drawn = gx.render_array(CUBE, size=preview.SIZE, hidden="remove", line_width="auto")[..., :3]
    assert np.array_equal(picture_of(CUBE), drawn)
    red = gx.Layer(CUBE, color="red", hidden="show")
    assert np.array_equal(picture_of(red), gx.render_array(red, size=preview.SIZE)[..., :3])


@pytest.mark.parametrize("camera", [CAMERA, gx.Camera.fit(CUBE, direction=(1, -2, 3), orthographic=True)], ids=repr)
def test_the_volume_of_a_camera_is_what_it_maps_into_the_picture(camera: gx.Camera) -> None:
    corners = preview._unproject(camera, preview.CORNERS)
    clip = camera.clip_from_world(preview.CAMERA_ASPECT) @ np.column_stack((corners, np.ones(8))).T
    assert np.allclose((clip[:3] / clip[3]).T, preview.CORNERS)
    for face in preview.VOLUME_FACES:
        sides = np.diff(corners[[*face, face[0]]], axis=0)
        assert abs(np.linalg.det(sides[:3])) < 1e-6 * np.abs(sides).max() ** 3  # flat


def test_the_volume_of_the_lecture_s_camera_ends_at_its_window() -> None:
    corners = preview._unproject(gx.Camera.eye_on_z(8, (-2, 2), (-3, 3)), preview.CORNERS)
    assert np.allclose(corners[4:], [(x, y, 0) for y in (-3, 3) for x in (-4, 4)])  # as wide as pictures are
    assert np.allclose(corners[:4, 2], 8 - 0.008)


def test_a_camera_without_depths_shows_its_window() -> None:
    corners = preview._unproject(gx.Camera.window((-1, 1), (-3, 3)), preview.CORNERS)
    assert np.allclose(corners[:4], [(x, y, 0) for y in (-3, 3) for x in (-4, 4)])


@pytest.mark.parametrize("thing", [gx.Mesh(np.zeros((0, 3)))], ids=repr)
def test_what_cannot_be_drawn_shows_no_picture(thing: Any) -> None:
    assert thing._repr_png_() is None


def test_without_an_adapter_a_model_is_shown_as_text(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise gx.NoAdapterError("no adapter")

    monkeypatch.setattr(preview, "render", refuse)
    assert CUBE._repr_png_() is None


def test_ipython_shows_the_picture_beside_the_text_and_a_terminal_draws_none(monkeypatch: pytest.MonkeyPatch) -> None:
    formatters = import_module("IPython.core.formatters")
    formatter = formatters.DisplayFormatter()
    data, _ = formatter.format(CUBE)
    assert data == {"text/plain": repr(CUBE), "image/png": CUBE._repr_png_()}
    monkeypatch.setattr(preview, "draw_preview", None)  # would fail if it were called
    assert formatter.format(CUBE, include={"text/plain"})[0] == {"text/plain": repr(CUBE)}


def test_ipython_shows_a_list_of_layers_as_one_picture_and_other_lists_as_text() -> None:
    layers = [gx.Layer(CUBE, color="red"), gx.Layer(CUBE, color="blue", transform=gx.translate(3, 0, 0))]
    shell_type = import_module("IPython.core.interactiveshell").InteractiveShell
    shell = shell_type.instance()
    try:
        show_lists()
        formatter = shell.display_formatter
        formatter.active_types = ["text/plain", "image/png"]
        data, _ = formatter.format(layers)
        with Image.open(io.BytesIO(data["image/png"])) as image:
            assert np.array_equal(
                np.asarray(image), gx.render_array(layers, size=preview.SIZE, hidden="remove")[..., :3]
            )
        for others in ([], [1, 2], [CUBE, 1]):
            assert set(formatter.format(others)[0]) == {"text/plain"}
    finally:
        shell_type.clear_instance()


def test_an_svg_document_is_text_that_shows_and_saves_itself(tmp_path: Path) -> None:
    document = gx.render_svg(CUBE, size=(64, 48))
    assert isinstance(document, str)
    assert type(document) is gx.SvgText
    assert document.startswith(("<svg", "<?xml"))
    assert document._repr_svg_() == document
    document.save(tmp_path / "cube.svg")
    assert (tmp_path / "cube.svg").read_text("utf-8") == document
    assert not hasattr(document, "__dict__")
    with pytest.raises(gx.ArgumentTypeError, match=r"^path must be a path, got int$"):
        document.save(3)  # type: ignore[arg-type]
    with pytest.raises(IsADirectoryError):
        document.save(tmp_path)
