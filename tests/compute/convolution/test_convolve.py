"""Convolution on the device beside float64 on the host, and what must hold of any convolution."""

from dataclasses import replace
from typing import Any, assert_type

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

import gpu_xform as gx
from gpu_xform.compute import backend
from gpu_xform.compute.kernels import convolve as kernel_module
from gpu_xform.compute.kernels.convolution_job import ConvolutionJob, Stencil
from gpu_xform.device import Device
from gpu_xform.errors import ArgumentError, ArgumentTypeError, PrecisionError
from gpu_xform.gpu.device import GpuDevice
from tests.support.reference_convolution import BORDERS, convolve_planes, correlate_planes, round_to
from tests.support.types import Array, DeviceFactory

# Of sum |kernel| max |image|, as the module's docstring promises.
TOLERANCE = {np.float32: 6e-7, np.float64: 1e-15}
WIDTHS = st.sampled_from([1, 2, 3, 4, 5, 8, 11])  # a pipeline is compiled for each
KERNELS = st.tuples(st.integers(1, 12), WIDTHS)
SHAPES = st.tuples(st.integers(12, 40), st.integers(12, 70))
SEEDS = st.integers(0, 2**32 - 1)


def some_image(shape: tuple[int, ...], dtype: npt.DTypeLike, seed: int = 0) -> Array:
    """An image in which no two pixels are alike, or in which all values of its type come up."""
    rng = np.random.default_rng([seed, *shape])
    if np.dtype(dtype).kind == "u":
        return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    return rng.normal(size=shape).astype(dtype)


def some_kernel(shape: tuple[int, int], seed: int = 1) -> Array:
    """A kernel without any symmetry."""
    return np.random.default_rng([seed, *shape]).normal(size=shape)


def assert_near(result: Array, exact: Array, kernel: Array, image: Array) -> None:
    bound = TOLERANCE[result.dtype.type] * np.abs(kernel).sum() * np.abs(image).max()
    assert np.abs(result - exact).max() <= bound


def set_most_direct_taps(monkeypatch: pytest.MonkeyPatch, n: float) -> None:
    """Let Fourier transforms correlate with matrices of more than `n` entries."""
    for name in ("MAX_DIRECT_TAPS_ON_CPU", "MAX_DIRECT_TAPS_ON_HOST"):
        monkeypatch.setattr(f"gpu_xform.compute.convolution.fourier.{name}", n)


@pytest.mark.float64
@settings(max_examples=12)
@given(SHAPES, KERNELS, st.sampled_from(BORDERS), st.sampled_from([np.float32, np.float64]), st.integers(0, 4), SEEDS)
def test_floats_are_those_of_float64(
    shape: tuple[int, int], sides: tuple[int, int], border: Any, dtype: npt.DTypeLike, channels: int, seed: int
) -> None:
    image = some_image((*shape, channels) if channels else shape, dtype, seed)
    kernel = some_kernel(sides, seed)
    origin = (seed % sides[0], seed % sides[1])
    exact = convolve_planes(image, kernel, border, origin)
    result = gx.convolve(image, kernel, border=border, origin=origin, alpha="independent")
    assert result.dtype == dtype
    assert_near(result, exact, kernel, image)


@settings(max_examples=8)
@given(SHAPES, KERNELS, st.sampled_from(BORDERS), SEEDS)
def test_correlation_does_not_flip(shape: tuple[int, int], sides: tuple[int, int], border: Any, seed: int) -> None:
    image, kernel = some_image(shape, np.float32, seed), some_kernel(sides, seed)
    origin = (seed % sides[0], seed % sides[1])
    exact = correlate_planes(image, kernel, border, origin)
    assert_near(gx.correlate(image, kernel, border=border, origin=origin), exact, kernel, image)


@pytest.mark.parametrize(
    ("channels", "sides"),
    [(1, (3, 3)), (4, (3, 3)), (3, (1, 7)), (2, (7, 7)), (1, (15, 15))],
    ids=str,
)
def test_bytes_are_rounded_exactly_but_for_one_in_fifty_thousand(channels: int, sides: tuple[int, int]) -> None:
    image, kernel = some_image((200, 260, channels), np.uint8), np.abs(some_kernel(sides))
    kernel /= kernel.sum()
    exact = round_to(image.dtype, convolve_planes(image, kernel, "reflect"))
    difference = np.abs(gx.convolve(image, kernel, alpha="independent").astype(int) - exact)
    assert difference.max() <= 1
    assert np.count_nonzero(difference) <= difference.size / 50_000


@pytest.mark.float64  # in which adapters that have it sum 16 bits
@pytest.mark.parametrize("sides", [(3, 3), (5, 1), (9, 9)])
def test_sixteen_bits_are_rounded_exactly(sides: tuple[int, int]) -> None:
    image, kernel = some_image((120, 150), np.uint16), some_kernel(sides)
    kernel /= np.abs(kernel).sum()
    assert np.array_equal(gx.convolve(image, kernel), round_to(image.dtype, convolve_planes(image, kernel, "reflect")))


@pytest.mark.parametrize(
    "kernel",
    [
        gx.box_kernel(2),
        np.full((1, 10), 0.1),
        np.array([[0.5, 0.5]]),
        np.outer([1, 4, 6, 4, 1], [1, 4, 6, 4, 1]) / 256,
        np.array([[0, -1, 0], [-1, 5, -1], [0, -1, 0]]),
        np.full((20, 20), 1 / 400),
    ],
    ids=str,
)
def test_bytes_by_fractions_are_exact_with_ties_to_even(kernel: Array) -> None:
    """The sums are those of integers; half a step is a tie, which sums of rounded products would lose."""
    image = some_image((90, 70), np.uint8)
    unit = np.abs(kernel[kernel != 0]).min()
    sums = convolve_planes(image, np.rint(kernel / unit), "reflect", (0, 0))
    halves = np.rint(2 * sums * unit) == 2 * sums / np.rint(1 / unit) if unit < 1 else np.zeros(sums.shape, bool)
    exact = np.where(halves, sums / np.rint(1 / unit) if unit < 1 else sums, sums * unit)
    assert np.array_equal(gx.convolve(image, kernel, origin=(0, 0)), round_to(image.dtype, exact))


def test_integers_are_clamped() -> None:
    """SciPy's wrap: 200 + 200 gives 144."""
    image = np.array([[200, 200, 200, 10, 10, 10]], np.uint8)
    assert gx.convolve(image, np.ones((1, 3)), border="edge").tolist() == [[255, 255, 255, 220, 30, 30]]
    assert gx.convolve(image, np.array([[1.0, 0.0, -1.0]]), border="edge").tolist() == [[0, 0, 0, 0, 0, 0]]
    assert gx.correlate(image, np.array([[1.0, 0.0, -1.0]]), border="edge").tolist() == [[0, 0, 190, 190, 0, 0]]


def test_a_white_pixel_becomes_the_kernel_and_by_correlation_the_flipped_one() -> None:
    image = np.zeros((9, 11), np.float32)
    image[4, 5] = 1.0
    kernel = np.arange(1.0, 13.0).reshape(3, 4)
    convolved = gx.convolve(image, kernel, border="constant", origin=(1, 2))
    assert np.array_equal(convolved[3:6, 3:7], kernel)
    correlated = gx.correlate(image, kernel, border="constant", origin=(1, 2))
    assert np.array_equal(correlated[3:6, 4:8], kernel[::-1, ::-1])
    assert np.count_nonzero(convolved) == np.count_nonzero(correlated) == kernel.size


@pytest.mark.float64
@settings(max_examples=20)
@given(SHAPES, st.sampled_from(["float32", "float64", "uint8", "uint16"]), SEEDS)
def test_the_identity_changes_nothing(shape: tuple[int, int], dtype: str, seed: int) -> None:
    image = some_image(shape, dtype, seed)
    assert np.array_equal(gx.convolve(image, [[1.0]]), image)
    assert np.array_equal(gx.convolve(image, np.pad([[1.0]], 2)), image)


@settings(max_examples=20)
@given(SHAPES, st.integers(0, 4), st.integers(0, 4), SEEDS)
def test_a_one_beside_the_origin_shifts(shape: tuple[int, int], down: int, right: int, seed: int) -> None:
    image = some_image(shape, np.uint8, seed)
    kernel = np.zeros((5, 5))
    kernel[down, right] = 1.0
    assert np.array_equal(gx.convolve(image, kernel, border="wrap"), np.roll(image, (down - 2, right - 2), axis=(0, 1)))


@pytest.mark.float64
@settings(max_examples=20)
@given(SHAPES, st.floats(-3, 3), SEEDS)
def test_it_is_linear(shape: tuple[int, int], factor: float, seed: int) -> None:
    first, second = some_image(shape, np.float64, seed), some_image(shape, np.float64, seed + 1)
    kernel = some_kernel((3, 5), seed)
    together = gx.convolve(first + factor * second, kernel)
    apart = gx.convolve(first, kernel) + factor * gx.convolve(second, kernel)
    np.testing.assert_allclose(together, apart, atol=1e-12)


@settings(max_examples=16)
@given(SHAPES, st.sampled_from([(5, 3), (23, 3)]), st.integers(0, 11), st.integers(0, 11), SEEDS)
def test_it_commutes_with_translation(
    shape: tuple[int, int], sides: tuple[int, int], down: int, right: int, seed: int
) -> None:
    """To the bit: in every place the same products are summed in the same order."""
    image, kernel = some_image(shape, np.float32, seed), some_kernel(sides, seed)
    moved = gx.convolve(np.roll(image, (down, right), axis=(0, 1)), kernel, border="wrap")
    assert np.array_equal(moved, np.roll(gx.convolve(image, kernel, border="wrap"), (down, right), axis=(0, 1)))


@pytest.mark.float64
@settings(max_examples=16)
@given(SHAPES, st.sampled_from([(1, 3), (3, 4), (9, 11), (12, 8)]), SEEDS)
def test_wrapped_around_it_keeps_the_sum(shape: tuple[int, int], sides: tuple[int, int], seed: int) -> None:
    image, kernel = some_image(shape, np.float64, seed), some_kernel(sides, seed)
    result = gx.convolve(image, kernel, border="wrap", origin=(0, 0))
    size = np.abs(kernel).sum() * np.abs(image).sum()
    assert abs(result.sum() - kernel.sum() * image.sum()) <= 1e-14 * size


@pytest.mark.float64
@settings(max_examples=16)
@given(SHAPES, st.sampled_from([(3, 3), (9, 11), (11, 8)]), st.sampled_from([np.float32, np.float64]), SEEDS)
def test_a_column_and_a_row_are_their_product(
    shape: tuple[int, int], sides: tuple[int, int], dtype: npt.DTypeLike, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    column, row = rng.normal(size=sides[0]), rng.normal(size=sides[1])
    image, product = some_image(shape, dtype, seed), np.outer(column, row)
    exact = convolve_planes(image, product, "symmetric", (0, 0))
    for kernel in ((column, row), product):
        assert_near(gx.convolve(image, kernel, border="symmetric", origin=(0, 0)), exact, product, image)


def test_a_large_product_takes_two_passes(process_device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    used = backend.find_backend(process_device)

    def run(job: ConvolutionJob) -> None:
        seen.append(len(job.stencils))
        used.run_convolution(job)

    monkeypatch.setattr(
        "gpu_xform.compute.convolution.convolve.find_backend", lambda _: replace(used, run_convolution=run)
    )
    image = some_image((40, 40), np.float32)
    gx.convolve(image, np.outer(*gx.gaussian(2.0)))
    gx.convolve(image, gx.gaussian(2.0))
    gx.convolve(image, gx.box_kernel(3))
    gx.convolve(image, some_kernel((9, 9)))
    assert seen == [2, 2, 1, 1]


@pytest.mark.parametrize(
    ("dtype", "sides", "is_direct", "is_constant"),
    [
        (np.float32, (31, 31), True, False),
        (np.float32, (101, 101), True, True),
        (np.float32, (101, 1), True, True),
        (np.float64, (1, 101), True, True),
        (np.float32, (31, 31), False, True),
        (np.float32, (101, 101), False, False),
        (np.float32, (101, 101), False, True),
        (np.float64, (101, 101), False, True),
    ],
)
def test_large_kernels_keep_the_bound(
    dtype: npt.DTypeLike, sides: tuple[int, int], is_direct: bool, is_constant: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a constant image and kernel, roundings add up instead of cancelling."""
    set_most_direct_taps(monkeypatch, np.inf if is_direct else 0)
    image = np.full((64, 58), 0.7, dtype) if is_constant else some_image((64, 58), dtype)
    kernel = np.full(sides, 0.3) if is_constant else some_kernel(sides)
    kernel[0, 0] += 0.1  # no product of a column and a row
    exact = convolve_planes(image, kernel, "symmetric")
    assert_near(gx.convolve(image, kernel, border="symmetric"), exact, kernel, image)


def test_four_channels_are_summed_in_parts_as_one_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a stage of its own; 20 rows are more than one sum takes."""
    set_most_direct_taps(monkeypatch, np.inf)
    image, kernel = some_image((24, 27, 4), np.float32), some_kernel((20, 5))
    exact = convolve_planes(image, kernel, "symmetric", (10, 2))
    result = gx.convolve(image, kernel, border="symmetric", origin=(10, 2), alpha="independent")
    assert_near(result, exact, kernel, image)


@pytest.mark.parametrize(("channels", "border"), [(1 + 2 * (k % 2), border) for k, border in enumerate(BORDERS)])
def test_fourier_transforms_give_the_same(channels: int, border: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    image, kernel = some_image((101, 90, channels), np.float32), some_kernel((8, 5))
    direct = gx.convolve(image, kernel, border=border, origin=(1, 4))
    set_most_direct_taps(monkeypatch, 0)
    monkeypatch.setattr("gpu_xform.compute.convolution.fourier.MAX_BLOCK", 48)  # for several strips
    monkeypatch.setattr("gpu_xform.compute.convolution.fourier.MIN_BLOCK", 48)
    by_fourier = gx.convolve(image, kernel, border=border, origin=(1, 4))
    assert not np.array_equal(by_fourier, direct)
    assert_near(by_fourier, direct, kernel, image)


def test_infinities_are_left_to_the_device() -> None:
    image = np.ones((60, 60), np.float32)
    image[3, 3] = np.inf
    result = gx.convolve(image, some_kernel((17, 17)))
    assert np.isfinite(result[12:, 12:]).all()


@pytest.mark.float64
def test_integers_with_the_largest_kernels() -> None:
    image, kernel = some_image((52, 61), np.uint16), np.abs(some_kernel((101, 101)))
    kernel /= kernel.sum()
    exact = round_to(np.uint16, convolve_planes(image, kernel, "symmetric"))
    assert np.array_equal(gx.convolve(image, kernel, border="symmetric"), exact)


@pytest.mark.parametrize(
    ("kernel", "dtype", "channels"),
    [
        (some_kernel((3, 5)), np.uint8, 3),
        (some_kernel((3, 5)), np.uint16, 2),
        (gx.gaussian(1.5), np.float32, 1),
        (gx.gaussian(1.5), np.uint8, 4),
    ],
    ids=["dense bytes", "dense", "separable floats", "separable bytes"],
)
def test_tiles_give_the_bytes_of_one_piece(
    device_with_limits: DeviceFactory, kernel: Any, dtype: npt.DTypeLike, channels: int
) -> None:
    image = some_image((47, 61, channels), dtype)
    whole = gx.convolve(image, kernel, alpha="independent")
    small = device_with_limits(max_binding_bytes=8192, max_workgroup_size=16)
    tiled = gx.convolve(image, kernel, alpha="independent", device=small)
    assert tiled.tobytes() == whole.tobytes()


def test_small_limits_do_make_tiles(device_with_limits: DeviceFactory) -> None:
    image = some_image((1, 83, 131, 1), np.float32)
    job = ConvolutionJob(
        device_with_limits(max_binding_bytes=8192),
        image,
        image.copy(),
        (Stencil(some_kernel((3, 5)), 1, 2),),
        lambda start, stop, size: np.arange(start, stop) % size,
        np.dtype(np.float32),
    )
    tiles = list(kernel_module.plan_tiles(job))
    assert len({tile.rows.start for tile in tiles}) > 1
    assert len({tile.columns.start for tile in tiles}) > 1


def test_over_a_bus_it_is_the_same(staging_device: GpuDevice) -> None:
    image = some_image((50, 60, 3), np.uint8)
    kernel = some_kernel((5, 3))
    assert np.array_equal(gx.convolve(image, kernel, device=staging_device), gx.convolve(image, kernel))


@pytest.mark.parametrize("shape", [(5, 17, 19), (3, 17, 19, 3), (2, 9, 33, 6)])
def test_a_stack_is_its_images(shape: tuple[int, ...]) -> None:
    images, kernel = some_image(shape, np.uint8), some_kernel((3, 3))
    result = gx.convolve(images, kernel, stack=True)
    assert np.array_equal(result, [gx.convolve(image, kernel) for image in images])
    assert gx.convolve(images[:0], kernel, stack=True).shape == (0, *shape[1:])


def test_a_kernel_per_channel() -> None:
    image = some_image((21, 23, 5), np.float32)
    kernels = np.stack([some_kernel((3, 3), seed) for seed in range(5)])
    result = gx.convolve(image, kernels)
    for k, kernel in enumerate(kernels):
        assert np.array_equal(result[..., k], gx.convolve(np.ascontiguousarray(image[..., k]), kernel))


def test_a_list_of_kernels_gives_a_list_of_results() -> None:
    image = some_image((21, 23), np.float32)
    slopes: list[Any] = [gx.sobel_kernel("x"), gx.sobel_kernel("y"), gx.gaussian(1.0)]
    results = gx.convolve(image, slopes)
    assert isinstance(results, list)
    for kernel, result in zip(slopes, results, strict=True):
        assert np.array_equal(result, gx.convolve(image, kernel))
    assert isinstance(gx.convolve(image, [[0.0, 1.0, 2.0]]), np.ndarray)


def test_infinities_and_nans_reach_as_far_as_the_kernel() -> None:
    for width in (3, 4, 11):
        for bad in (np.nan, np.inf):
            image = np.zeros((40, 60), np.float32)
            image[20, 30] = bad
            result = gx.convolve(image, some_kernel((5, width)), origin=(2, width // 2))
            rows, columns = np.nonzero(~np.isfinite(result))
            assert sorted(set(rows.tolist())) == list(range(18, 23))
            assert len(set(columns.tolist())) == width
            assert rows.size == 5 * width


def test_the_result_goes_where_out_says() -> None:
    image, kernel = some_image((40, 50), np.float32), some_kernel((3, 3))
    expected = gx.convolve(image, kernel)
    out = np.empty_like(image)
    assert gx.convolve(image, kernel, out=out) is out
    assert np.array_equal(out, expected)
    wide = np.zeros((40, 100), np.float32)
    gx.convolve(image, kernel, out=wide[:, ::2])
    assert np.array_equal(wide[:, ::2], expected)
    assert not wide[:, 1::2].any()
    outs = [np.empty_like(image) for _ in range(2)]
    both = gx.convolve(image, [kernel, kernel.T], out=outs)
    assert all(a is b for a, b in zip(both, outs, strict=True))
    assert np.array_equal(gx.convolve(image, kernel, out=image), expected)


@pytest.mark.parametrize("dtype", [">f4", ">u2"])
def test_any_byte_order_and_layout(dtype: str) -> None:
    image = some_image((30, 40), np.dtype(dtype).newbyteorder("="))
    kernel = some_kernel((3, 3))
    expected = gx.convolve(image, kernel)
    assert np.array_equal(gx.convolve(image.astype(dtype), kernel), expected)
    assert np.array_equal(gx.convolve(np.asfortranarray(image), kernel), expected)
    turned = gx.convolve(image[::-1, ::-1], kernel)
    assert np.array_equal(turned, gx.convolve(np.ascontiguousarray(image[::-1, ::-1]), kernel))


class TestAlpha:
    # Each device makes an instance of this class.
    @settings(max_examples=12, suppress_health_check=[HealthCheck.differing_executors])
    @given(SHAPES, st.sampled_from([np.uint8, np.uint16, np.float32]), SEEDS)
    def test_colours_are_weighted_by_alpha(self, shape: tuple[int, int], dtype: npt.DTypeLike, seed: int) -> None:
        image = some_image((*shape, 4), dtype, seed)
        if np.dtype(dtype).kind == "f":
            image = np.abs(image)
            image[..., 3] = np.minimum(image[..., 3], 1.0)
        kernel = np.abs(some_kernel((3, 5), seed))
        kernel /= kernel.sum()
        largest = 1.0 if np.dtype(dtype).kind == "f" else float(np.iinfo(dtype).max)
        opacity = image[..., 3:].astype(np.float64)
        weighted = convolve_planes(image[..., :3] * opacity, kernel, "reflect")
        alpha = np.clip(convolve_planes(opacity, kernel, "reflect"), 0.0, largest)
        exact = np.concatenate([weighted / alpha, alpha], axis=-1)
        result = gx.convolve(image, kernel).astype(np.float64)
        assert np.abs(result - exact).max() <= (0.51 if largest > 1 else 1e-5)

    def test_what_is_transparent_lends_no_colour(self) -> None:
        image = np.zeros((9, 9, 4), np.uint8)
        image[..., :3] = 77, 33, 200  # of what is not seen
        image[4, 4] = 10, 20, 30, 255
        result = gx.convolve(image, gx.box_kernel(3))
        assert (result[3:6, 3:6] == (10, 20, 30, 28)).all()
        result[3:6, 3:6] = 0
        assert not result.any()

    @pytest.mark.parametrize(
        "kernel", [gx.box_kernel(3), 2.0 * gx.box_kernel(3), np.array([[-1.0, 3.0, -1.0]])], ids=str
    )
    def test_opaque_colours_are_those_without_alpha(self, kernel: Array) -> None:
        image = some_image((30, 31, 4), np.uint8)
        image[..., 3] = 255
        result = gx.convolve(image, kernel).astype(int)
        assert np.abs(result[..., :3] - gx.convolve(np.ascontiguousarray(image[..., :3]), kernel)).max() <= 1
        assert (result[..., 3] == 255).all()

    def test_alpha_can_be_kept(self) -> None:
        image = some_image((30, 31, 4), np.uint8)
        result = gx.convolve(image, gx.sobel_kernel(), alpha="keep")
        assert np.array_equal(result[..., 3], image[..., 3])
        assert np.array_equal(result[..., :3], gx.convolve(np.ascontiguousarray(image[..., :3]), gx.sobel_kernel()))


class TestLinear:
    @pytest.mark.float64
    def test_light_is_averaged(self) -> None:
        """Half of white light is sRGB 188, not 128."""
        image = np.zeros((4, 4), np.uint8)
        image[:, ::2] = 255
        assert (gx.convolve(image, [[0.5, 0.5]], origin=(0, 0), border="wrap", linear=True) == 188).all()
        floats = gx.convolve(image / 255.0, [[0.5, 0.5]], origin=(0, 0), border="wrap", linear=True)
        np.testing.assert_allclose(floats, 0.735357, atol=1e-6)

    @pytest.mark.parametrize("dtype", [np.uint8, pytest.param(np.uint16, marks=pytest.mark.float64)])
    def test_the_identity_keeps_every_value(self, dtype: npt.DTypeLike) -> None:
        largest = np.iinfo(dtype).max
        image = np.arange(largest + 1, dtype=dtype).reshape(16, -1)
        assert np.array_equal(gx.convolve(image, [[1.0]], linear=True), image)

    def test_alpha_is_no_light(self) -> None:
        image = some_image((20, 20, 4), np.uint8)
        image[..., 3] = np.maximum(image[..., 3], 1)
        result = gx.convolve(image, gx.box_kernel(3), linear=True)
        assert np.abs(result[..., 3].astype(int) - gx.convolve(image, gx.box_kernel(3))[..., 3]).max() <= 1
        assert np.array_equal(gx.convolve(image, [[1.0]], linear=True), image)


class TestPillow:
    @pytest.mark.parametrize(
        ("mode", "dtype", "channels"),
        [
            ("L", np.uint8, ()),
            ("RGB", np.uint8, (3,)),
            ("RGBA", np.uint8, (4,)),
            ("I;16", np.uint16, ()),
            ("F", np.float32, ()),
        ],
    )
    def test_an_image_gives_an_image_of_its_mode(
        self, mode: str, dtype: npt.DTypeLike, channels: tuple[int, ...]
    ) -> None:
        array = some_image((17, 29, *channels), dtype)
        result = gx.convolve(Image.fromarray(array), gx.box_kernel(3))
        assert result.mode == mode
        assert np.array_equal(np.asarray(result), gx.convolve(array, gx.box_kernel(3)))

    def test_grey_with_alpha_is_weighted_by_it(self) -> None:
        array = some_image((17, 29, 2), np.uint8)
        result = gx.convolve(Image.fromarray(array, "LA"), gx.box_kernel(3))
        assert result.mode == "LA"
        assert np.array_equal(np.asarray(result), gx.convolve(array[..., [0, 0, 0, 1]], gx.box_kernel(3))[..., 2:])

    def test_it_keeps_what_is_said_of_the_picture(self) -> None:
        image = Image.fromarray(some_image((9, 9, 3), np.uint8))
        image.info.update(dpi=(300, 300), transparency=(1, 2, 3))
        assert gx.convolve(image, gx.box_kernel(3)).info == {"dpi": (300, 300)}

    @pytest.mark.parametrize("mode", ["P", "1", "CMYK", "I"])
    def test_other_modes_are_refused(self, mode: str) -> None:
        with pytest.raises(ArgumentError, match=rf"^image must have a mode of L, .*, got '{mode}'"):
            gx.convolve(Image.new(mode, (5, 5)), gx.box_kernel(3))


IMAGE = np.zeros((8, 9), np.float32)
BOX = np.ones((3, 3))


@pytest.mark.parametrize(
    ("image", "kernel", "keywords", "message"),
    [
        (IMAGE[0], BOX, {}, r"image must have shape \(h, w\) or \(h, w, c\), got \(9,\)"),
        (IMAGE, BOX, {"stack": True}, r"image must have shape \(k, h, w\) or .* with stack=True, got \(8, 9\)"),
        (IMAGE[:0], BOX, {}, r"image must have pixels, got \(0, 9\)"),
        (np.zeros((8, 9, 0)), BOX, {}, r"image must have pixels, got \(8, 9, 0\)"),
        (IMAGE, np.ones((0, 3)), {}, r"kernel must have entries, got shape \(0, 3\)"),
        (IMAGE, ([], [1.0]), {}, r"kernel must have entries, got shape \(0, 1\)"),
        (IMAGE, [[1.0, np.nan, 1.0]], {}, r"kernel must be finite, got nan at index \(0, 1\)"),
        (IMAGE, ([1.0], [1.0, np.inf, 0.0]), {}, r"kernel\[1\] must be finite, got inf at index 1"),
        (IMAGE, [BOX, np.full((1, 1), np.inf)], {}, r"kernel\[1\] must be finite, got inf at index \(0, 0\)"),
        (IMAGE, np.ones(3), {}, r"kernel must have shape \(m, n\) or \(c, m, n\), or be a column and a row, got shape"),
        (IMAGE, [[1.0], [1.0, 2.0]], {}, r"kernel must be a rectangular array of numbers"),
        (IMAGE, np.ones((2, 3)), {}, r"kernel must have odd sides, or an origin, got shape \(2, 3\)"),
        (IMAGE, BOX, {"origin": (0, 3)}, r"origin must lie inside the kernel's shape \(3, 3\), got \(0, 3\)"),
        (IMAGE, BOX, {"origin": (-1, 0)}, r"origin must lie inside the kernel's shape \(3, 3\), got \(-1, 0\)"),
        (IMAGE, np.ones((2, 3, 3)), {}, r"kernel must have one matrix, or one for each of 1 channels, got 2"),
        (IMAGE, BOX, {"border": "mirror"}, r"border must be one of reflect, .*, got 'mirror'"),
        (IMAGE, BOX, {"alpha": "straight"}, r"alpha must be one of premultiplied, .*, got 'straight'"),
        (
            IMAGE,
            np.ones((17, 1)),
            {},
            r"kernel must reach at most 7 rows beyond an image of 8, with border='reflect', got 8",
        ),
        (IMAGE, np.ones((1, 21)), {"border": "wrap"}, r"kernel must reach at most 9 columns beyond .* got 10"),
        (IMAGE, np.ones((19, 1)), {"border": "symmetric"}, r"kernel must reach at most 8 rows beyond .* got 9"),
        (np.zeros((8, 9, 4)), gx.sobel_kernel(), {}, r"kernel must have a positive sum if .* got 0"),
        (IMAGE, BOX, {"out": IMAGE[:7].copy()}, r"out must have shape \(8, 9\), got \(7, 9\)"),
        (IMAGE, [BOX, BOX], {"out": IMAGE.copy()}, r"out must be a list of 2 arrays, as there are kernels"),
        (Image.new("L", (9, 8)), BOX, {"out": IMAGE.copy()}, r"out is for arrays"),
        (Image.new("L", (9, 8)), BOX, {"stack": True}, r"image must be an array with stack=True, got a Pillow image"),
    ],
)
def test_impossible_arguments(image: Any, kernel: Any, keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=f"^{message}"):
        gx.convolve(image, kernel, **keywords)


@pytest.mark.parametrize(
    ("image", "kernel", "keywords", "message"),
    [
        (IMAGE.astype(np.int64), BOX, {}, r"image must hold float32, float64, uint8 or uint16, got int64"),
        (IMAGE.astype(bool), BOX, {}, r"image must hold float32, float64, uint8 or uint16, got bool"),
        (IMAGE.astype(np.float16), BOX, {}, r"image must hold float32, .*, got float16"),
        (IMAGE, BOX * 1j, {}, r"kernel must hold real numbers, got dtype complex128"),
        (IMAGE, [["a"]], {}, r"kernel must hold real numbers"),
        (IMAGE, BOX, {"origin": 1}, r"origin must be a row and a column, got 1"),
        (IMAGE, BOX, {"origin": (1.0, 1)}, r"origin\[0\] must be a whole number, got 1.0"),
        (IMAGE, BOX, {"out": [[1.0]]}, r"out must be a NumPy array, got list"),
        (IMAGE, BOX, {"out": IMAGE.astype(np.float64)}, r"out must have dtype float32, got float64"),
        (IMAGE, BOX, {"device": "llvmpipe"}, r"device must be a Device, got 'llvmpipe'"),
    ],
)
def test_unusable_types(image: Any, kernel: Any, keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentTypeError, match=f"^{message}"):
        gx.convolve(image, kernel, **keywords)


def test_nothing_is_written_if_an_argument_is_wrong() -> None:
    out = [np.full((8, 9), 7, np.float32) for _ in range(2)]
    with pytest.raises(ArgumentError):
        gx.convolve(IMAGE, [BOX, np.ones((17, 1))], out=out)
    assert all((each == 7).all() for each in out)


@pytest.mark.float64
def test_edges_and_zeros_may_be_wider_than_the_image() -> None:
    image = some_image((3, 4), np.float64)
    for border in ("edge", "constant"):
        kernel = some_kernel((31, 15))
        result = gx.convolve(image, kernel, border=border)
        np.testing.assert_allclose(result, convolve_planes(image, kernel, border), atol=1e-12)


def test_double_precision_needs_a_device_that_has_it(single_device: GpuDevice) -> None:
    with pytest.raises(PrecisionError, match=r"has no double precision \(shader-f64\): convert the image to float32$"):
        gx.convolve(IMAGE.astype(np.float64), BOX, device=single_device)
    image = some_image((40, 50), np.uint16)
    result = gx.convolve(image, gx.box_kernel(3), device=single_device)
    assert np.array_equal(result, gx.convolve(image, gx.box_kernel(3)))


def test_types_tell_what_comes_out() -> None:
    """Mypy reads these."""
    image, kernels = np.ones((9, 9), np.float32), [gx.box_kernel(3), gx.sobel_kernel()]
    picture = Image.fromarray(np.zeros((9, 9), np.uint8))
    assert_type(gx.convolve(image, BOX), npt.NDArray[Any])
    assert_type(gx.convolve(image, [[1.0]]), npt.NDArray[Any])
    assert_type(gx.correlate(image, kernels), list[npt.NDArray[Any]])
    assert_type(gx.convolve(picture, gx.gaussian(1.0)), Image.Image)
    assert_type(gx.correlate(picture, [gx.gaussian(1.0), gx.gaussian(2.0)]), list[Image.Image])
