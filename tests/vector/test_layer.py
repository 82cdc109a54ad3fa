"""Vector layers: what is refused before anything is written."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from gpu_xform.errors import ArgumentError
from gpu_xform.vector import Points, Polygons, Stroke, VectorLayer
from gpu_xform.vector.layer import Gradients

SOLID = Stroke(1.0, ())
GOOD = VectorLayer(
    "", np.zeros((3, 4), np.float32), np.zeros(3, np.bool_), np.zeros(3, np.float32), np.ones((1, 4)), SOLID, SOLID
)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"segments": np.zeros((3, 3))}, r"segments must have shape \(n, 4\), got \(3, 3\)"),
        ({"segments": np.array([[0, 1, 2, 3], [4, np.nan, 6, 7], [0, 0, 0, 0]])}, r"segments .* nan at index \(1, 1\)"),
        ({"segments": np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 0, -2e7, 0]])}, "segments .* 1e.07 pixels, got 2e.07"),
        ({"hidden": np.zeros(2, np.bool_)}, r"hidden must have shape \(3,\), got \(2,\)"),
        ({"dash_start": np.zeros((3, 1))}, r"dash_start must have shape \(3,\), got \(3, 1\)"),
        ({"dash_start": np.array([0, np.inf, 0])}, "dash_start must be finite, got inf at index 1"),
        ({"colors": np.ones((2, 4))}, r"colors must have shape \(1, 4\) or \(3, 4\), got \(2, 4\)"),
    ],
)
def test_layers_whose_arrays_do_not_fit_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        dataclasses.replace(GOOD, **change)


def test_so_are_polygons_and_points() -> None:
    with pytest.raises(ArgumentError, match=r"points must have shape \(n, 2\), got \(3, 3\)"):
        Polygons(np.array([0, 3]), np.zeros((3, 3)), np.ones((1, 4)))
    with pytest.raises(ArgumentError, match=r"colors must have shape \(1, 4\) or \(2, 4\), got \(3, 4\)"):
        Polygons(np.array([0, 3, 6]), np.zeros((6, 2)), np.ones((3, 4)))
    with pytest.raises(ArgumentError, match=r"points must be finite, got nan at index \(2, 0\)"):
        Polygons(np.array([0, 3]), np.array([[0, 0], [1, 0], [np.nan, 1]]), np.ones((1, 4)))
    with pytest.raises(ArgumentError, match=r"circles must have shape \(n, 3\), got \(3, 2\)"):
        Points(np.zeros((3, 2)), np.ones((1, 4)))
    with pytest.raises(ArgumentError, match=r"colors must have shape \(1, 4\) or \(3, 4\), got \(3, 3\)"):
        Points(np.zeros((3, 3)), np.ones((3, 3)))


def test_a_layer_that_moves_takes_its_gradients_along() -> None:
    gradients = Gradients(np.array([[0.0, 1.0, 2.0, 3.0]]), np.ones((1, 2, 4)))
    polygons = Polygons(np.array([0, 3]), np.zeros((3, 2)), np.ones((1, 4)), gradients)
    moved = dataclasses.replace(GOOD, polygons=polygons).moved(10.0, 20.0).polygons
    assert moved is not None
    assert moved.gradients is not None
    np.testing.assert_array_equal(moved.gradients.axes, [[10.0, 21.0, 12.0, 23.0]])
    np.testing.assert_array_equal(moved.points, [[10.0, 20.0]] * 3)
