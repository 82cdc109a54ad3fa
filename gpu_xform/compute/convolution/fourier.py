"""Correlation by fast Fourier transforms on the host, block by block, which large kernels gain by.

Overlap-save: a block of the image, transformed, multiplied and transformed back, holds right results but for as many
rows and columns at its start as the kernel has but one (Oppenheim and Schafer, Discrete-Time Signal Processing, 8.7.3).
"""

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ...device import Device
from ...host import HostDevice, count_threads
from ..kernels.convolution_job import Extend, Stencil, copy_extended, fits

# Sides of blocks: shorter ones transform more overlap, longer ones leave the caches of a CPU.
KERNELS_PER_BLOCK = 12
BLOCKS_PER_STRIP = 4
MIN_BLOCK, MAX_BLOCK = 256, 512  # MAX_BLOCK where the kernel is no larger than half of it
# Divided by a float both ways: what is divided by the integer 1 NumPy 2 computes in a wider type, which takes
# float32 seven times as long.
NORM: Literal["ortho"] = "ortho"
# On a CPU a dense kernel of more takes longer on the device; measured with float32.
MAX_DIRECT_TAPS_ON_CPU = 256
MAX_DIRECT_TAPS_ON_HOST = 324


def choose_fourier(images: npt.NDArray[Any], stencil: Stencil, device: Device, dtype: np.dtype[Any]) -> bool:
    """Say whether Fourier transforms should correlate these images with a stencil, in `dtype`.

    Sums over a whole block carry its NaNs and infinities everywhere, and their rounding errors into integers; those are
    left to the device as long as it has room for the stencil.
    """
    if not fits(stencil.matrix.shape, dtype):
        return True
    most = MAX_DIRECT_TAPS_ON_HOST if isinstance(device, HostDevice) else MAX_DIRECT_TAPS_ON_CPU
    is_faster = stencil.matrix.size > most and device.adapter.kind == "CPU"
    return is_faster and images.dtype.kind == "f" and bool(np.isfinite(images).all())


def correlate_by_fourier(
    images: npt.NDArray[Any], out: npt.NDArray[Any], stencil: Stencil, extend: Extend, dtype: np.dtype[Any]
) -> None:
    """Write images (k, h, w, c), correlated with a stencil in `dtype`, into `out`; integers are rounded and clamped."""
    sides = [_choose_block(n, size) for n, size in zip(stencil.matrix.shape, images.shape[1:3], strict=True)]
    spectrum = np.fft.rfft2(stencil.matrix[::-1, ::-1].astype(dtype), sides)
    overlap = [n - 1 for n in stencil.matrix.shape]
    step_y, step_x = (side - n for side, n in zip(sides, overlap, strict=True))
    height, width = images.shape[1:3]

    def fill(corner: tuple[int, int]) -> None:
        """Correlate a strip of blocks side by side: its rows are long, and read and written one after the other."""
        y, left = corner
        n_y, n_strip = min(step_y, height - y), min(BLOCKS_PER_STRIP * step_x, width - left)
        rows = extend(y - stencil.top, y + n_y + stencil.bottom, height)
        columns = extend(left - stencil.left, left + n_strip + stencil.right, width)
        strip = np.empty((*images.shape[:1], len(rows), len(columns), *images.shape[3:]), images.dtype)
        copy_extended(images, rows, columns, strip)
        planes = np.moveaxis(strip, 3, 1).astype(dtype, copy=False)
        results = np.empty((*planes.shape[:2], n_y, n_strip), dtype)
        for x in range(0, n_strip, step_x):
            n_x = min(step_x, n_strip - x)
            product = np.fft.rfft(planes[..., x : x + n_x + overlap[1]], sides[1], norm=NORM)
            product = np.fft.fft(product, sides[0], axis=-2, norm=NORM)
            product *= spectrum
            # The rows at the start are not transformed back.
            product = np.fft.ifft(product, axis=-2, norm=NORM)[..., overlap[0] : overlap[0] + n_y, :]
            results[..., x : x + n_x] = np.fft.irfft(product, sides[1], norm=NORM)[..., overlap[1] : overlap[1] + n_x]
        if out.dtype.kind == "u":
            results = np.clip(np.rint(results), 0, np.iinfo(out.dtype).max)
        out[:, y : y + n_y, left : left + n_strip] = np.moveaxis(results, 1, 3)

    step_strip = BLOCKS_PER_STRIP * step_x
    corners = [(y, x) for y in range(0, height, step_y) for x in range(0, width, step_strip)]
    with ThreadPoolExecutor(min(len(corners), count_threads())) as pool:
        list(pool.map(fill, corners))


def _choose_block(n: int, size: int) -> int:
    """Return how long blocks are for a side of a kernel, `n`, and of an image: a length that transforms fast.

    Of those that are about KERNELS_PER_BLOCK kernels long, the one of which the fewest numbers cover the image.
    """
    wanted = max(min(MAX_BLOCK, KERNELS_PER_BLOCK * n), 2 * n, MIN_BLOCK)
    longest = _next_fast_length(min(wanted + wanted // 4, size + n - 1))
    shortest = max(wanted - wanted // 4, 2 * n)
    lengths = [side for side in _list_fast_lengths(longest) if side >= shortest] or [longest]
    return min(lengths, key=lambda side: (-(-size // (side - n + 1)) * side, side))


def _next_fast_length(n: int) -> int:
    """Return the smallest fast length that is `n` or more."""
    return min(side for side in _list_fast_lengths(2 * n) if side >= n)


def _list_fast_lengths(longest: int) -> list[int]:
    """Return products of a power of 2 and of 1, 3, 5, 9 or 15, up to `longest`, in no order."""
    return [factor << k for factor in (1, 3, 5, 9, 15) for k in range(longest.bit_length()) if factor << k <= longest]
