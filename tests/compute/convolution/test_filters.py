import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

import gpu_xform as gx
from gpu_xform.compute.convolution.filters import NAMED_KERNELS
from gpu_xform.errors import ArgumentError, ArgumentTypeError


@given(st.floats(0.0, 20.0), st.floats(0.0, 20.0), st.floats(0.5, 6.0))
def test_a_gaussian_is_scipys(vertical: float, horizontal: float, truncate: float) -> None:
    column, row = gx.gaussian((vertical, horizontal), truncate=truncate)
    for weights, sigma in ((column, vertical), (row, horizontal)):
        assert abs(weights.sum() - 1.0) <= 1e-14
        radius = len(weights) // 2
        impulse = np.zeros(2 * radius + 1)
        impulse[radius] = 1.0
        expected = ndimage.gaussian_filter1d(impulse, sigma, truncate=truncate, mode="constant") if radius else [1.0]
        np.testing.assert_allclose(weights, expected, atol=1e-15)


def test_a_gaussian_of_one_number_is_the_same_both_ways() -> None:
    column, row = gx.gaussian(2.0)
    assert len(column) == 17
    assert np.array_equal(column, row)


def test_a_blurred_image_is_scipys() -> None:
    image = np.random.default_rng(0).random((50, 60))
    blurred = gx.convolve(image, gx.gaussian((1.5, 3.0)), border="symmetric")
    np.testing.assert_allclose(blurred, ndimage.gaussian_filter(image, (1.5, 3.0)), atol=1e-14)


@pytest.mark.parametrize(("axis", "number"), [("x", 1), ("y", 0)])
def test_sobel_is_scipys_and_positive_along_the_axis(axis: Any, number: int) -> None:
    image = np.random.default_rng(0).random((50, 60))
    slope = gx.convolve(image, gx.sobel_kernel(axis), border="symmetric")
    np.testing.assert_allclose(slope, ndimage.sobel(image, number), atol=1e-14)
    ramp = np.indices((9, 9))[number].astype(float)
    assert (gx.convolve(ramp, gx.sobel_kernel(axis))[2:-2, 2:-2] == 8.0).all()


@pytest.mark.parametrize("n", [1, 2, 5])
def test_a_box_is_a_mean(n: int) -> None:
    assert gx.box_kernel(n).shape == (n, n)
    assert abs(gx.box_kernel(n).sum() - 1.0) <= 1e-15


@pytest.mark.parametrize("name", NAMED_KERNELS)
def test_named_kernels_keep_brightness_or_find_what_is_not_flat(name: str) -> None:
    kernel = NAMED_KERNELS[name]()
    assert kernel.shape[0] % 2 == kernel.shape[1] % 2 == 1
    assert abs(kernel.sum() - (0.0 if name in {"edges", "laplace", "sobel-x", "sobel-y"} else 1.0)) <= 1e-15


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: gx.gaussian(-1.0), "sigma must be 0 or more, got -1.0"),
        (lambda: gx.gaussian(np.nan), "sigma must be finite, got nan"),
        (lambda: gx.gaussian((1, 2, 3)), "sigma must be one number or two, got shape (3,)"),  # type: ignore[arg-type]
        (lambda: gx.gaussian(1e9), "sigma must reach at most 16,384 pixels, got 4e+09"),
        (lambda: gx.gaussian(1.0, truncate=0), "truncate must be more than 0, got 0.0"),
        (lambda: gx.box_kernel(0), "n must be 1 or more, got 0"),
        (lambda: gx.sobel_kernel("z"), "axis must be 'x' or 'y', got 'z'"),  # type: ignore[arg-type]
    ],
)
def test_impossible_arguments(make: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=f"^{re.escape(message)}$"):
        make()  # type: ignore[operator]


def test_a_box_has_a_whole_side() -> None:
    with pytest.raises(ArgumentTypeError, match=r"^n must be a whole number, got 2\.5$"):
        gx.box_kernel(2.5)  # type: ignore[arg-type]
