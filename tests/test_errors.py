"""The exceptions: what they say, what can be read off them, and that they survive pickling and copying."""

import copy
import inspect
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import errors
from gpu_xform.formats import load_mesh
from gpu_xform.geometry.edges import resolve_edges

CLASSES = [
    value
    for name, value in vars(errors).items()
    if inspect.isclass(value) and issubclass(value, Exception) and not name.startswith("_")
]


@pytest.mark.parametrize("kind", CLASSES)
def test_errors_pickle_and_copy(kind: type[Exception]) -> None:
    error = kind("what went wrong")
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(error, protocol))  # noqa: S301
        assert type(again) is kind
        assert again.args == error.args
    assert type(copy.copy(error)) is type(copy.deepcopy(error)) is kind
    assert str(copy.copy(error)) == "what went wrong"


@pytest.mark.parametrize("kind", [errors.ArgumentError, errors.ArgumentTypeError, errors.SingularMatrixError])
def test_what_an_error_is_about_survives_pickling_and_copying(kind: type[errors.ArgumentError]) -> None:
    error = kind.expecting("size", "be positive", -1)
    for again in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):  # noqa: S301
        assert str(again) == "size must be positive, got -1"
        assert (again.argument, again.expected) == ("size", "be positive")


def test_the_parts_of_a_message() -> None:
    expecting = errors.ArgumentError.expecting
    assert str(expecting("m", "be finite")) == "m must be finite"
    assert str(expecting("m", "be finite", 0)) == "m must be finite, got 0"
    assert str(expecting("d", "not be 0", reason="it divides")) == "d must not be 0: it divides"
    assert str(expecting("m", "be a file", "'a'", reason="no header")) == "m must be a file, got 'a': no header"


def test_an_error_of_one_text_is_about_no_argument() -> None:
    error = errors.ArgumentError("both or neither")
    assert (error.argument, error.expected) == (None, None)
    assert error.args == ("both or neither",)


CALLS: list[tuple[Callable[[], Any], str, str]] = [
    (lambda: gx.rotate_x(float("nan")), "angle", "be finite"),
    (lambda: gx.rotate((0, 0, 0), 1), "axis", "not be the zero vector"),
    (lambda: gx.translate("1", 2, 3), "x", "hold real numbers"),
    (lambda: gx.perspective(0, 1, 1, 2), "fov_y", "lie between 0 and 180 degrees"),
    (lambda: gx.orthographic(1, 1, 0, 1, 0, 1), "right", "differ from left"),
    (
        lambda: gx.look_at((0, 0, 1), (0, 0, 0), up=(0, 0, 2)),
        "up",
        "not be parallel to target - eye = (0.0, 0.0, -1.0)",
    ),
    (lambda: gx.inverse(np.eye(2)), "m", "have shape (3, 3) or (4, 4)"),
    (lambda: gx.inverse(np.zeros((3, 3))), "m", "have an inverse"),
    (lambda: gx.chain(gx.identity(), np.eye(3)), "matrices[1]", "have shape (4, 4)"),
    (lambda: gx.samples.grid(1.5), "n", "be a whole number"),  # type: ignore[arg-type]
    (lambda: gx.samples.grid(0), "n", "be at least 1"),
    (
        lambda: gx.samples.cube().transformed(np.diag([1, 1, 1, 2])),
        "matrix",
        "be affine, with the last row (0, 0, 0, 1)",
    ),
    (lambda: resolve_edges(gx.samples.cube(), [(0, 9)]), "edges", "name points in 0..7"),
    (lambda: gx.Scene().add(name=""), "name", "not be empty"),
    (lambda: gx.Scene().world("wheel"), "node", "be a node of this scene, or its name"),
    (lambda: load_mesh(3), "source", "be a path or a binary file"),  # type: ignore[arg-type]
    (lambda: gx.compare_images("a.png", "b.png", threshold=256), "threshold", "be from 0 to 255"),
    (lambda: gx.Layer(gx.samples.cube(), hidden="fog"), "hidden", "be one of 'show', 'remove', 'dash', 'fade'"),  # type: ignore[arg-type]
    (lambda: gx.Camera.fit(gx.samples.cube(), margin=1), "margin", "lie in [-50, 0.5)"),
]


@pytest.mark.parametrize(("call", "argument", "expected"), CALLS, ids=[f"{row[1]}: {row[2]}" for row in CALLS])
def test_an_error_holds_the_argument_and_what_was_expected(
    call: Callable[[], Any], argument: str, expected: str
) -> None:
    with pytest.raises((errors.ArgumentError, errors.ArgumentTypeError)) as caught:
        call()
    assert caught.value.argument == argument
    assert caught.value.expected == expected
