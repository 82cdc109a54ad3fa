"""Arguments of a wrong kind are typed errors that name them, before any work."""

import io
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import ArgumentError, ArgumentTypeError

CUBE = gx.samples.cube()
ARRAY: Any = np.ones(3)
FIVE: Any = 5


def obj() -> io.BytesIO:
    return io.BytesIO(b"v 0 0 0\n")


def image() -> Any:
    return np.ones((3, 3), np.float32)


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "file_type": (lambda: gx.load_mesh(obj(), file_type=FIVE), "file_type must be a text, got int"),
    "bytes as a type": (lambda: gx.load_scene(obj(), file_type=b"obj"), "file_type must be a text"),  # type: ignore[arg-type]
    "the type to save": (lambda: gx.save_mesh(CUBE, obj(), file_type=FIVE), "file_type must be a text"),
    "progress": (lambda: gx.turntable(CUBE, 2, "x.gif", progress=FIVE), "progress must be callable, got 5"),
    "progress of save": (lambda: gx.animate(CUBE, [np.eye(4)]).save("x.gif", progress=FIVE), "progress must be call"),
    "progress of a file": (lambda: gx.transform_file("a", "b", np.eye(4), progress=FIVE), "progress must be callable"),
    "n_frames": (lambda: gx.turntable(CUBE, n_frames=3), "n_frames: turntable takes the number of its frames as"),
    "degrees": (lambda: gx.rotate_x(1, degrees=ARRAY), "degrees must be True or False"),
    "project": (lambda: gx.transform_file("a", "b", np.eye(4), project=ARRAY), "project must be True or False"),
    "resume": (lambda: gx.transform_file("a", "b", np.eye(4), resume=ARRAY), "resume must be True or False"),
    "linear": (lambda: gx.convolve(image(), image(), linear=ARRAY), "linear must be True or False"),
    "alpha": (lambda: gx.convolve(image(), image(), alpha=ARRAY), "alpha must be a text"),
    "border": (lambda: gx.convolve(image(), image(), border=ARRAY), "border must be a text"),
    "precision": (lambda: gx.transform_points(np.ones((3, 3)), np.eye(4), precision=ARRAY), "precision must be a text"),
    "order": (lambda: gx.transform_points(np.ones((3, 3)), np.eye(4), order=ARRAY), "order must be a text"),
    "adapter": (lambda: gx.Device(FIVE), "adapter must be a text, got int"),
    "the default adapter": (lambda: gx.default_device(ARRAY), "adapter must be a text"),
    "limits": (lambda: gx.Device(limits=FIVE), "limits must be Limits"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_kind_is_named(name: str) -> None:
    call, message = WRONG[name]
    with pytest.raises(ArgumentTypeError, match=f"^{message}"):
        call()


def test_a_rasteriser_that_is_no_text_is_named() -> None:
    with pytest.raises(ArgumentError, match="rasterizer must be"):
        gx.render(CUBE, rasterizer=ARRAY)


def test_what_a_broadcast_repeats_beyond_any_memory_is_refused_by_its_shape() -> None:
    points = np.broadcast_to(np.float32(1), (1 << 40, 3))
    matrices = np.broadcast_to(1.0, (1 << 40, 4, 4))
    for call in (
        lambda: gx.transform_points(points, np.eye(4)),
        lambda: gx.transform_points(np.ones((2, 3)), matrices),
        lambda: gx.inverse(matrices),
        lambda: gx.rotate_x(np.broadcast_to(1.0, (1 << 40,))),
        lambda: gx.bounds(points),
        lambda: gx.render_array(points, size=(24, 16)),
        lambda: gx.Mesh(np.eye(3), np.broadcast_to(0, (1 << 40, 3))),
    ):
        with pytest.raises(ArgumentError, match=r"must take at most 274,877,906,944 bytes, got shape \(1099511627776"):
            call()
    assert gx.transform_points(np.broadcast_to(np.float32(1), (1000, 3)), np.eye(4)).shape == (1000, 3)


@pytest.mark.parametrize(
    "call",
    [
        lambda: gx.transform_vectors(np.ones((2, 3)), np.eye(4), normalize=np.ones((2, 2))),  # type: ignore[arg-type]
        lambda: gx.compare_images([[1, 2], [3]], [[1, 2], [3]]),  # type: ignore[arg-type]
        lambda: gx.Springs(gx.samples.cube(), mass=[[1, 2], [3]], stretch=1.0),
        lambda: gx.render(gx.samples.cube(), size=np.ma.masked_array([1.0, 2.0], [True, False])),  # type: ignore[arg-type]
        lambda: gx.Camera.fit(np.broadcast_to(np.float32(1), (1 << 40, 3))),
    ],
)
def test_what_random_calls_found_is_an_argument_error(call: Callable[[], object]) -> None:
    with pytest.raises((ArgumentError, ArgumentTypeError)):
        call()


@pytest.mark.parametrize(
    ("name", "axis"), [("+Z", (0, 0, 1)), ("z", (0, 0, 1)), ("-Y", (0, -1, 0)), (" x ", (1, 0, 0))]
)
def test_directions_are_axes_by_name(name: str, axis: tuple[int, int, int]) -> None:
    aside = (0.3, 0.5, -0.9)
    for make in (
        lambda direction: gx.rotate(direction, 0.4),
        gx.reflect,
        gx.project_onto,
        lambda direction: gx.look_at(aside, (0, 0, 0), direction),
        lambda direction: gx.Camera.look_at(aside, (0, 0, 0), direction).clip_from_world(1.0),
        lambda direction: gx.Camera.fit(CUBE, direction=direction).clip_from_world(1.0),
        lambda direction: gx.Camera.fit(CUBE, direction=aside, up=direction).clip_from_world(1.0),
    ):
        np.testing.assert_array_equal(make(name), make(axis))
    for text in ("up", "+W", "0,0,1", ""):
        with pytest.raises(ArgumentError, match=r"must be three numbers, or an axis such as '\+Y' or '-z', got"):
            gx.reflect(text)
