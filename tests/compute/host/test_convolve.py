"""Convolution on the host: numba's loops give the bytes of NumPy, and both what a graphics adapter gives."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.compute.host import convolve as host_convolve
from gpu_xform.compute.host.tap_groups import MAX_GROUP, SUMS_PER_SUM, TapGroups
from gpu_xform.compute.kernels.convolution_job import Stencil
from gpu_xform.device import Device
from gpu_xform.gpu.device import GpuDevice
from tests.support.python_run import python_output
from tests.support.reference_convolution import BORDERS
from tests.support.types import Array

SEEDS = st.integers(0, 2**32 - 1)
KERNELS = st.tuples(st.integers(1, 13), st.integers(1, 13))
KINDS = st.sampled_from([("float32", 0), ("float32", 4), ("float64", 3), ("uint8", 0), ("uint8", 4), ("uint16", 2)])


def some_image(shape: tuple[int, ...], dtype: npt.DTypeLike, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "u":
        return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    return rng.normal(size=shape).astype(dtype)


def some_kernel(shape: tuple[int, int], seed: int) -> Array:
    """A kernel without symmetry, of a positive sum."""
    kernel = np.random.default_rng(seed).normal(size=shape)
    return np.asarray(kernel / max(np.abs(kernel).sum(), 1e-3) + 2.0 / kernel.size)


@pytest.fixture
def by_loops(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Let numba compute whatever the size, in bands, blocks and windows so small that there are many."""
    monkeypatch.setattr(host_convolve, "MIN_COMPILED_PRODUCTS", 0)
    monkeypatch.setattr(host_convolve, "NUMBERS_PER_BLOCK", 28)
    monkeypatch.setattr(host_convolve, "MIN_ROWS_PER_BAND", 7)
    monkeypatch.setattr(host_convolve, "MIN_ROWS_AHEAD", 2)
    monkeypatch.setattr(host_convolve, "MAX_ROWS_AHEAD", 3)
    monkeypatch.setenv("GPU_XFORM_THREADS", "5")
    return monkeypatch


@settings(max_examples=60)
@given(st.tuples(st.integers(13, 40), st.integers(13, 70)), KERNELS, KINDS, st.sampled_from(BORDERS), SEEDS)
def test_loops_give_the_bytes_of_numpy(
    host: Device, shape: tuple[int, int], sides: tuple[int, int], kind: tuple[str, int], border: Any, seed: int
) -> None:
    dtype, channels = kind
    image, kernel = some_image((*shape, channels) if channels else shape, dtype, seed), some_kernel(sides, seed)
    origin = (seed % sides[0], seed % sides[1])
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(host_convolve, "MIN_COMPILED_PRODUCTS", np.inf)
        expected = gx.correlate(image, kernel, border=border, origin=origin, device=host)
        monkeypatch.setattr(host_convolve, "MIN_COMPILED_PRODUCTS", 0)
        for numbers, rows, ahead in ((28, 7, 2), (4096, 64, 16)):
            monkeypatch.setattr(host_convolve, "NUMBERS_PER_BLOCK", numbers)
            monkeypatch.setattr(host_convolve, "MIN_ROWS_PER_BAND", rows)
            monkeypatch.setattr(host_convolve, "MIN_ROWS_AHEAD", ahead)
            monkeypatch.setattr(host_convolve, "MAX_ROWS_AHEAD", ahead + 1)
            result = gx.correlate(image, kernel, border=border, origin=origin, device=host)
            assert result.tobytes() == expected.tobytes()


@pytest.mark.parametrize("kernel", [gx.gaussian(4.0), np.ones((1, 40)), np.ones((33, 1)), gx.box_kernel(41)], ids=str)
@pytest.mark.parametrize("dtype", ["float32", "uint8"])
def test_long_sums_and_two_passes_too(host: Device, by_loops: pytest.MonkeyPatch, kernel: Any, dtype: str) -> None:
    image = some_image((57, 61, 3), dtype, 3)
    result = gx.convolve(image, kernel, origin=None if isinstance(kernel, tuple) else (0, 0), device=host)
    by_loops.setattr(host_convolve, "MIN_COMPILED_PRODUCTS", np.inf)
    expected = gx.convolve(image, kernel, origin=None if isinstance(kernel, tuple) else (0, 0), device=host)
    assert result.tobytes() == expected.tobytes()


@settings(max_examples=12)
@given(st.tuples(st.integers(13, 40), st.integers(13, 70)), KERNELS, KINDS, st.sampled_from(BORDERS), SEEDS)
def test_it_is_the_twin_of_the_shader(
    device: GpuDevice,
    host: Device,
    shape: tuple[int, int],
    sides: tuple[int, int],
    kind: tuple[str, int],
    border: Any,
    seed: int,
) -> None:
    dtype, channels = kind
    image, kernel = some_image((*shape, channels) if channels else shape, dtype, seed), some_kernel(sides, seed)
    keywords: dict[str, Any] = {"border": border, "origin": (0, 0), "alpha": "independent"}
    on_host = gx.convolve(image, kernel, device=host, **keywords)
    on_device = gx.convolve(image, kernel, device=device, **keywords)
    assert on_host.dtype == on_device.dtype
    difference = np.abs(on_host.astype(np.float64) - on_device)
    if image.dtype.kind == "u":
        assert difference.max() <= 1
        assert np.count_nonzero(difference) <= max(1, difference.size / 10_000)
    else:
        bound = {"float32": 12e-7, "float64": 2e-15}[dtype]  # twice what each promises
        assert difference.max() <= bound * np.abs(kernel).sum() * np.abs(image).max()


@pytest.mark.usefixtures("by_loops")
def test_layouts_and_parts_of_arrays(host: Device) -> None:
    image, kernel = some_image((40, 50, 3), "uint8", 1), some_kernel((3, 5), 1)
    expected = gx.convolve(image, kernel, device=host)
    assert np.array_equal(gx.convolve(np.asfortranarray(image), kernel, device=host), expected)
    wide = np.zeros((40, 100, 3), np.uint8)
    assert gx.convolve(image, kernel, out=wide[:, ::2], device=host).base is wide
    assert np.array_equal(wide[:, ::2], expected)
    assert not wide[:, 1::2].any()
    image.flags.writeable = False
    assert np.array_equal(gx.convolve(image, kernel, device=host), expected)


@pytest.mark.usefixtures("by_loops")
def test_infinities_and_nans_reach_as_far_as_the_kernel(host: Device) -> None:
    for width in (1, 2, 3, 4, 5, 7, 11):
        image = np.zeros((40, 60), np.float32)
        image[20, 30] = np.nan
        result = gx.convolve(image, some_kernel((5, width), 1), origin=(2, width // 2), device=host)
        rows, columns = np.nonzero(np.isnan(result))
        assert (rows.size, len(set(rows.tolist())), len(set(columns.tolist()))) == (5 * width, 5, width)


def test_the_number_of_threads_changes_no_byte_nor_does_numba() -> None:
    code = """
        import hashlib, sys
        import numpy as np
        import gpu_xform as gx
        from gpu_xform.compute.host import convolve
        if {has_numba}:
            convolve.MIN_COMPILED_PRODUCTS = 0
        else:
            sys.modules["numba"] = None
        rng = np.random.default_rng(0)
        digest = hashlib.sha256()
        for image in (rng.normal(size=(301, 203)).astype(np.float32), rng.integers(0, 256, (301, 103, 4), np.uint8)):
            for kernel in (rng.random((5, 5)), gx.gaussian(3.0)):
                digest.update(gx.convolve(image, kernel, device=gx.Device("host")).tobytes())
        print(digest.hexdigest())
    """
    digests = {python_output(code.format(has_numba=True), GPU_XFORM_THREADS=threads) for threads in ("1", "2")}
    digests.add(python_output(code.format(has_numba=False)))
    assert len(digests) == 1


def test_small_images_import_neither_numba_nor_wgpu() -> None:
    code = """
        import sys
        import numpy as np
        import gpu_xform as gx
        gx.convolve(np.ones((64, 64, 4), np.uint8), gx.box_kernel(3), device=gx.Device("host"))
        print(sorted({"numba", "wgpu"} & set(sys.modules)))
    """
    assert python_output(code, VK_DRIVER_FILES="/nonexistent", VK_ICD_FILENAMES="/nonexistent") == "[]\n"


@pytest.mark.parametrize("n", [1, 2, 3, 5, 6, 7, 31, 101])
def test_groups_hold_each_tap_once(n: int) -> None:
    taps = TapGroups.of(Stencil(np.ones((n, n)), 0, 0), np.dtype(np.float32))
    sizes = np.diff(taps.starts)
    assert sizes.sum() == n
    assert sizes.max() <= MAX_GROUP
    ends = np.flatnonzero(taps.levels.ravel())
    assert (np.diff(ends, prepend=-1) == SUMS_PER_SUM).all()
