"""The viewport transform."""

import numpy as np

from gpu_xform.drawing.view import ndc_to_pixels


def test_ndc_goes_from_the_bottom_left_up_and_pixels_from_the_top_left_down() -> None:
    ndc = np.array([(-1.0, 1.0, 0.3), (1.0, -1.0, 0.3), (0.0, 0.0, 0.3), (-0.5, 0.75, 0.3), (3.0, -5.0, 0.3)])
    pixels = [(0.0, 0.0), (300.0, 200.0), (150.0, 100.0), (75.0, 25.0), (600.0, 600.0)]
    assert ndc_to_pixels(ndc, (300, 200)).tolist() == [list(pixel) for pixel in pixels]
    assert ndc_to_pixels(ndc[:, np.newaxis, :2], (300, 200)).shape == (5, 1, 2)
