"""Correlation of images with small matrices, tile by tile."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from ...gpu import layouts, uniforms
from ...gpu.buffers import UNIFORM, Buffer
from ...gpu.chunking import name_number_type
from ...gpu.device import GpuDevice, require_gpu_device
from ...gpu.dispatch import Binding, dispatch
from ...gpu.shaders import ComputePipeline
from .convolution_job import MAX_STENCIL_BYTES, ConvolutionJob, Stencil, copy_extended
from .transform import POOL_OWNER

NUMBERS_PER_VECTOR = 4
MAX_VECTORS_PER_BLOCK = 8  # rows of whole blocks of any kind
MAX_ROWS_PER_BLOCK = 8
WORKGROUP_SIZE = 64  # 256 take half as long again on lavapipe
MAX_TILE_BYTES = 32 << 20  # smaller ones lose more to the calls than they gain by the caches of a CPU
MIN_TILE_ROWS = 32  # beside its borders, before an image is cut into columns too
# Every rounding of a long sum may err the same way. These lengths keep the promise of `convolution.convolve`.
MAX_TAPS_PER_SUM = 49  # beyond, the taps of each row of a matrix are summed by themselves
MAX_COLUMNS_PER_SUM = 32  # beyond, those of each four columns
MAX_ROWS_PER_SUM = 16  # of sums of rows


class Format(IntEnum):
    """How buffers hold the numbers of an image; the numbers are the WGSL constants."""

    REAL = 0
    UINT8 = 1
    UINT16 = 2

    @classmethod
    def of(cls, dtype: np.dtype[Any]) -> "Format":
        """Return the format of a dtype."""
        return {"u1": cls.UINT8, "u2": cls.UINT16}.get(dtype.str[1:], cls.REAL)


class Block(NamedTuple):
    """How many rows, of how many vectors each, an invocation makes."""

    rows: int
    vectors: int

    @classmethod
    def choose(cls, matrix: Float64Array, n_channels: int) -> "Block":
        """Return the block for a matrix and pixels of `n_channels`: the one that loads numbers the fewest times."""
        rows, columns = matrix.shape
        if columns == 1 and COLUMN.rows <= rows <= MAX_TAPS_PER_SUM:
            return COLUMN
        return PIXELS if n_channels == NUMBERS_PER_VECTOR and columns <= MAX_COLUMNS_PER_SUM else VECTORS


VECTORS, PIXELS, COLUMN = Block(2, 4), Block(2, 8), Block(8, 1)


@dataclass(frozen=True)
class Tile:
    """A part of one image, or several whole images."""

    images: slice
    rows: slice
    columns: slice


@dataclass(frozen=True)
class _Margins:
    """How far the stencils reach beyond a tile, in pixels."""

    top: int
    bottom: int
    left: int
    right: int

    @classmethod
    def around(cls, stencils: tuple[Stencil, ...]) -> "_Margins":
        sides = ("top", "bottom", "left", "right")
        return cls(*(sum(getattr(stencil, side) for stencil in stencils) for side in sides))


def run_convolution(job: ConvolutionJob) -> None:
    """Write the correlation of all images into `job.out`, which may be `job.images` only if one tile holds all."""
    device = require_gpu_device(job.device)
    passes = _Passes(device, job)
    with device.lock:
        coefficients = [_upload_coefficients(device, job, number) for number in range(len(job.stencils))]
        for tile in plan_tiles(job):
            passes.run(tile, coefficients)


def plan_tiles(job: ConvolutionJob) -> Iterator[Tile]:
    """Cut the images so that buffers hold a tile and its margins."""
    n_images, height, width, n_channels = job.images.shape
    margins = _Margins.around(job.stencils)
    item_bytes = job.images.itemsize if len(job.stencils) == 1 else max(job.images.itemsize, job.dtype.itemsize)
    pixel_bytes = n_channels * item_bytes
    n_pixels = min(MAX_TILE_BYTES, job.device.limits.max_bound_bytes) // pixel_bytes
    beside = margins.left + margins.right + 2 * MAX_VECTORS_PER_BLOCK * NUMBERS_PER_VECTOR
    above = margins.top + margins.bottom + MAX_ROWS_PER_BLOCK
    columns = min(width, max(NUMBERS_PER_VECTOR, n_pixels // (min(height, MIN_TILE_ROWS) + above) - beside))
    rows = min(height, max(MAX_ROWS_PER_BLOCK, n_pixels // (columns + beside) - above))
    if (rows, columns) == (height, width):
        step = max(1, n_pixels // ((columns + beside) * (rows + above)))
        for first in range(0, n_images, step):
            yield Tile(slice(first, min(first + step, n_images)), slice(0, height), slice(0, width))
        return
    for image in range(n_images):
        for y in range(0, height, rows):
            for x in range(0, width, columns):
                yield Tile(slice(image, image + 1), slice(y, min(y + rows, height)), slice(x, min(x + columns, width)))


class _Passes:
    """The passes of a job over one tile after the other, by buffers that are kept."""

    def __init__(self, device: GpuDevice, job: ConvolutionJob) -> None:
        self._job = job
        self._device = device
        self._pool = device.pool
        self._margins = _Margins.around(job.stencils)
        self._n_channels = int(job.images.shape[-1])
        self._blocks = [Block.choose(stencil.matrix, self._n_channels) for stencil in job.stencils]

    def run(self, tile: Tile, coefficients: list[Binding]) -> None:
        """Copy a tile in, run the passes, and copy the result out."""
        job = self._job
        source, n_columns, stride, padded_height = self._upload(tile)
        n_images = tile.images.stop - tile.images.start
        height = tile.rows.stop - tile.rows.start
        result_stride = _align(self._count_vectors(n_columns), MAX_VECTORS_PER_BLOCK)
        # Images stand one below the other. What lies between two of them is computed for nothing.
        n_rows = (n_images - 1) * padded_height + height
        heights = self._pass_heights(n_rows)
        buffers, strides, formats = [source], [stride], [Format.of(job.images.dtype)]
        for number in range(len(heights)):
            is_last = number == len(heights) - 1
            formats.append(Format.of(job.out.dtype) if is_last else Format.REAL)
            itemsize = job.out.itemsize if is_last else job.dtype.itemsize
            strides.append(result_stride)
            n_bytes = heights[number] * strides[-1] * NUMBERS_PER_VECTOR * itemsize
            buffers.append(self._pool.scratch(POOL_OWNER, "destination" if is_last else "rows", n_bytes))
        structs = [self._pack_parameters(number, heights[number], strides) for number in range(len(heights))]
        parameters = uniforms.upload(self._device, POOL_OWNER, "convolution passes", structs)
        idle = [self._pool.scratch(POOL_OWNER, f"idle {k}", NUMBERS_PER_VECTOR * job.dtype.itemsize) for k in range(2)]
        used = [*buffers, *idle, parameters[0].buffer, coefficients[0].buffer]
        with self._device.encode_commands(*used, label="convolve") as encoder:
            for number in range(len(heights)):
                pipeline = self._compile(number, formats[number], formats[number + 1])
                bindings = self._device.bind_groups.bind(
                    pipeline,
                    parameters=parameters[number],
                    coefficients=coefficients[number],
                    **_views("source", buffers[number], formats[number], idle[0]),
                    **_views("destination", buffers[number + 1], formats[number + 1], idle[1]),
                )
                n_blocks = int(structs[number].view(layouts.CONVOLUTION_PASS[job.dtype])["n_blocks"][0])
                dispatch(encoder, pipeline, bindings, -(-n_blocks // self._workgroup_size))
        row_numbers = strides[-1] * NUMBERS_PER_VECTOR
        with buffers[-1].map_read(n_rows * row_numbers * job.out.itemsize) as view:
            numbers = view.view(job.out.dtype.newbyteorder("=")).reshape(n_rows, row_numbers)
            numbers = numbers[:, : n_columns * self._n_channels]
            for k, image in enumerate(range(tile.images.start, tile.images.stop)):
                pixels = numbers[k * padded_height :][:height].reshape(height, n_columns, self._n_channels)
                job.out[image, tile.rows, tile.columns] = pixels

    def _compile(self, number: int, source_format: Format, destination_format: Format) -> ComputePipeline:
        """Return the pipeline of a pass, of the stage for its blocks."""
        job = self._job
        height, width = job.stencils[number].matrix.shape
        constants: dict[str, float] = {
            "workgroup_size": self._workgroup_size,
            "source_format": source_format,
            "destination_format": destination_format,
            "premultiplies": job.opaque > 0 and number == 0,
            "unpremultiplies": job.opaque > 0 and number == len(job.stencils) - 1,
        }
        stage = "convolve_column"
        if self._blocks[number] != COLUMN:
            constants |= {"kernel_width": width, "sums_rows": height * width > MAX_TAPS_PER_SUM}
            stage = "convolve_pixels"
        if self._blocks[number] == VECTORS:
            constants |= {"n_channels": self._n_channels, "sums_quads": width > MAX_COLUMNS_PER_SUM}
            stage = "convolve"
        return self._device.pipelines.compute(stage, name_number_type(job.dtype), **constants)

    @property
    def _workgroup_size(self) -> int:
        return min(WORKGROUP_SIZE, self._device.limits.max_workgroup_size)

    def _count_vectors(self, n_pixels: int) -> int:
        return -(-n_pixels * self._n_channels // NUMBERS_PER_VECTOR)

    def _pass_heights(self, height: int) -> list[int]:
        """Return how many rows each pass makes, whole blocks: the rows that the next pass reads."""
        heights = []
        for stencil, block in zip(reversed(self._job.stencils), reversed(self._blocks), strict=True):
            height = _align(height, block.rows)
            heights.append(height)
            height += len(stencil.matrix) - 1
        return heights[::-1]

    def _upload(self, tile: Tile) -> tuple[Buffer, int, int, int]:
        """Upload a tile with its margins; return where, its columns, vectors from row to row, rows of each image."""
        job, margins = self._job, self._margins
        height, width = job.images.shape[1:3]
        n_columns = tile.columns.stop - tile.columns.start
        widest = max(stencil.matrix.shape[1] for stencil in job.stencils)
        n_vectors = _align(self._count_vectors(n_columns), MAX_VECTORS_PER_BLOCK) + self._count_vectors(widest) + 2
        rows = job.extend(tile.rows.start - margins.top, tile.rows.stop + margins.bottom, height)
        columns = job.extend(tile.columns.start - margins.left, tile.columns.stop + margins.right, width)
        n_images = tile.images.stop - tile.images.start
        row_numbers = n_vectors * NUMBERS_PER_VECTOR
        n_bytes = n_images * len(rows) * row_numbers * job.images.itemsize
        buffer = self._pool.scratch(POOL_OWNER, "source", n_bytes)
        with buffer.map_write(n_bytes) as view:
            padded = view.view(job.images.dtype.newbyteorder("=")).reshape(n_images, len(rows), row_numbers)
            numbers = padded[:, :, : len(columns) * self._n_channels]
            pixels = numbers.reshape(*numbers.shape[:2], len(columns), self._n_channels)
            copy_extended(job.images[tile.images], rows, columns, pixels)
        return buffer, n_columns, n_vectors, len(rows)

    def _pack_parameters(self, number: int, height: int, strides: list[int]) -> npt.NDArray[np.uint8]:
        job = self._job
        struct = np.zeros((), layouts.CONVOLUTION_PASS[job.dtype])
        struct["scale"] = job.scale if number == len(job.stencils) - 1 else 1.0
        struct["opaque"] = job.opaque
        struct["zero"] = job.zero
        struct["offset_fraction"], struct["offset_whole"] = job.offset
        block = self._blocks[number]
        blocks_per_row = strides[number + 1] // block.vectors
        struct["n_blocks"] = height // block.rows * blocks_per_row
        struct["blocks_per_row"] = blocks_per_row
        struct["source_stride"], struct["destination_stride"] = strides[number], strides[number + 1]
        matrix = job.stencils[number].matrix
        struct["kernel_height"] = len(matrix)
        struct["rows_per_sum"] = MAX_ROWS_PER_SUM if matrix.size > MAX_TAPS_PER_SUM else len(matrix)
        return layouts.as_bytes(struct)


def _views(name: str, buffer: Buffer, number_format: Format, idle: Buffer) -> dict[str, Buffer]:
    """Return the bindings of a buffer of numbers or of words, of which the other is idle."""
    is_real = number_format is Format.REAL
    return {name: buffer if is_real else idle, f"{name}_words": idle if is_real else buffer}


def _upload_coefficients(device: GpuDevice, job: ConvolutionJob, number: int) -> Binding:
    matrix = job.stencils[number].matrix
    padded = np.zeros((len(matrix), _align(matrix.shape[1], NUMBERS_PER_VECTOR)), job.dtype)
    padded[:, : matrix.shape[1]] = matrix
    content = np.zeros(MAX_STENCIL_BYTES // job.dtype.itemsize, job.dtype)
    content[: padded.size] = padded.ravel()
    buffer = device.pool.scratch(POOL_OWNER, f"coefficients {number}", MAX_STENCIL_BYTES, UNIFORM)
    buffer.upload_changed(content)
    return Binding(buffer, 0, MAX_STENCIL_BYTES)


def _align(n: int, step: int) -> int:
    return -(-n // step) * step
