"""Correlation of images with small matrices, on the host."""

from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.interrupts import defer_interrupts
from ...host import count_threads
from ..kernels.convolution_job import ConvolutionJob, copy_extended
from . import convolution_vectorized as vectorized
from .choose import as_constant, run_compiled
from .tap_groups import TapGroups

Array = npt.NDArray[Any]

# Fewer products take NumPy less time than importing numba takes.
MIN_COMPILED_PRODUCTS = 1 << 21
NUMBERS_PER_BLOCK = 4096  # of a row, so that a window of rows stays in a processor's second cache
MIN_ROWS_PER_BAND = 64
MIN_ROWS_AHEAD = 16  # of a window: when it is full, the rows that are needed again are moved to its begin
MAX_ROWS_AHEAD = 80
PAD_NUMBERS = 80  # of a row: what is read of a tile beyond the last number; no multiple of a page, whose lines meet
NUMPY_BLOCK_NUMBERS = 1 << 16  # of a band that NumPy works on, so that what it makes stays in a cache


@np.errstate(over="ignore", invalid="ignore")
def run_convolution(job: ConvolutionJob) -> None:
    """Write the correlation of all images into `job.out`, which shares no memory with `job.images`."""
    height, width = job.images.shape[1:3]
    top, bottom, left, right = (
        sum(getattr(stencil, side) for stencil in job.stencils) for side in ("top", "bottom", "left", "right")
    )
    rows = job.extend(-top, height + bottom, height)
    columns = job.extend(-left, width + right, width)
    passes = [TapGroups.of(stencil, job.dtype) for stencil in job.stencils]
    n_products = job.images.size * sum(taps.coefficients.size for taps in passes)
    if n_products >= MIN_COMPILED_PRODUCTS and _run_compiled(job, rows, columns, left, passes):
        return
    _run_vectorized(job, rows, columns, passes)


def _run_compiled(job: ConvolutionJob, rows: Array, columns: Array, left: int, passes: list[TapGroups]) -> bool:
    n_images, height, width, n_channels = job.images.shape
    flat = n_images, height, width * n_channels
    out = job.out if job.out.flags.c_contiguous else np.empty(job.out.shape, job.out.dtype)
    first, second = [*passes, TapGroups.none(job.dtype)][:2]
    fraction, whole = job.offset
    numbers = np.array([job.zero, job.scale, job.opaque, fraction, whole, _largest(job)], job.dtype)
    margin, beside = len(rows) - height, len(columns) - width
    above_second = max(second.coefficients.shape[1] - 1, 0)
    n_threads = count_threads()
    rows_per_band = max(MIN_ROWS_PER_BAND, -(-height // n_threads))
    pixels_per_block = min(-(-NUMBERS_PER_BLOCK // n_channels), width)
    above = np.array([margin - above_second, above_second])
    capacities = above + np.clip(above, MIN_ROWS_AHEAD, MAX_ROWS_AHEAD)
    strides = np.array([pixels_per_block + beside, pixels_per_block]) * n_channels + PAD_NUMBERS
    n_workers = min(n_threads, n_images * -(-height // rows_per_band))
    scratch = np.empty((n_workers, capacities @ strides + 2 * strides[1]), job.dtype)
    target = out.reshape(flat)
    is_done = run_compiled(
        _import_loops,
        "correlate",
        as_constant(np.ascontiguousarray(job.images).reshape(flat)),
        rows,
        columns,
        n_channels,
        left,
        first.coefficients.ravel(),
        first.starts,
        first.levels,
        first.is_column,
        second.coefficients.ravel(),
        second.starts,
        second.levels,
        numbers,
        job.opaque > 0,
        target,
        rows_per_band,
        pixels_per_block,
        np.append(capacities, strides),
        scratch,
    )
    if is_done and out is not job.out:
        job.out[...] = out
    return is_done


def _run_vectorized(job: ConvolutionJob, rows: Array, columns: Array, passes: list[TapGroups]) -> None:
    n_images, height, width, n_channels = job.images.shape
    margin = len(rows) - height
    step = max(1, NUMPY_BLOCK_NUMBERS // (len(columns) * n_channels), margin)
    n_numbers = width * n_channels
    for image in range(n_images):
        for start in range(0, height, step):
            n_rows = min(step, height - start)
            n_read = n_rows + margin
            pixels = np.empty((1, n_read, len(columns), n_channels), job.images.dtype)
            copy_extended(job.images[image : image + 1], rows[start : start + n_read], columns, pixels)
            source = pixels[0].astype(job.dtype)
            source -= job.dtype.type(job.zero)
            if job.opaque > 0:
                vectorized.premultiply(source)
            sums = source.reshape(n_read, -1)
            for taps in passes:
                if taps.is_column:
                    n_read -= taps.coefficients.shape[1] - 1
                elif len(passes) == 1:
                    n_read = n_rows
                sums = vectorized.correlate_lines(sums, n_read, n_numbers, n_channels, taps)
            target = job.out[image, start : start + n_rows]
            vectorized.write_pixels(
                sums.reshape(n_rows, width, n_channels), target, job.scale, job.opaque, job.offset, _largest(job)
            )


@cache
def _import_loops() -> ModuleType | None:
    try:
        with defer_interrupts():
            from . import convolution_loops
    except ModuleNotFoundError as error:
        if error.name != "numba":
            raise
        return None
    return convolution_loops


def _largest(job: ConvolutionJob) -> int:
    """Return the largest integer of the result's type; 0 for floats."""
    return int(np.iinfo(job.out.dtype).max) if job.out.dtype.kind == "u" else 0
