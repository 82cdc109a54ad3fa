"""Filled faces in order: those of one mean colour too, if light differs across them."""

import numpy as np

from gpu_xform.vector.fills import FilledFaces
from gpu_xform.vector.layer import Gradients
from gpu_xform.vector.painters import RaggedPolygons
from gpu_xform.vector.sort_fills import sort_fills


def test_polygons_of_one_mean_colour_are_sorted_if_they_have_gradients() -> None:
    near, far = ([(0, 0, z), (10, 0, z), (0, 10, z)] for z in (0.8, 0.2))
    corners = np.array([*near, *far], float)
    polygons = RaggedPolygons(np.array([0, 3, 6]), corners, np.arange(2))
    colors = np.array([[0.5, 0.5, 0.5, 1.0]] * 2)
    ends = np.array([[[0.4, 0.4, 0.4, 1.0], [0.6, 0.6, 0.6, 1.0]], [[0.6, 0.6, 0.6, 1.0], [0.4, 0.4, 0.4, 1.0]]])
    gradients = Gradients(np.array([[0.0, 0.0, 10.0, 0.0]] * 2), ends)
    fill = FilledFaces(
        polygons, colors, np.ones(2, np.bool_), lambda: (corners.reshape(2, 3, 3), np.arange(2)), gradients
    )
    ordered = sort_fills([fill], (1.0, 1.0, 1.0, 1.0))
    assert ordered.gradients is not None
    np.testing.assert_array_equal(ordered.gradients.ends, ends[::-1])
