"""The loops of convolution on the host: images through lines of taps, band by band.

A pass has `n_lines` lines of `n_taps` taps: a matrix is its rows, a column one line. The taps of a line are added in
groups, and groups in the order of `tap_groups.py`, so that neither bands nor blocks of columns nor the number of
threads changes a byte. No tap is added that the matrix does not have, nor contracted with its product.

LLVM would keep sums in memory, group for group: a tile of them stays in registers while all taps are added. A window of
rows of the image, and one of the first pass's results, moves down a block of columns and stays in a processor's cache.
"""

from functools import partial
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .compile import compile_function, compile_loop
from .packed_loops import VECTOR_BYTES
from .tap_groups import MAX_GROUP

Array = npt.NDArray[Any]

TILE_BYTES = 128  # 192 are no faster, 256 do not fit into the registers of two rows and their products


@intrinsic(prefer_literal=True)  # type: ignore[untyped-decorator, unused-ignore]
def correlate_tiles(
    typing_context: Any,  # noqa: ARG001
    n_together: Any,
    source: Any,
    at: Any,
    stride: Any,
    step: Any,
    n: Any,
    k: Any,
    starts: Any,
    levels: Any,
    is_deep: Any,
    out: Any,
    between: Any,
) -> Any:
    """Write the sums of one row of `n` numbers, or of two, into `out`, a tile at a time, whose sums stay in registers.

    The lower of two rows meets each line of `source` a line earlier, so that both share what is read. Up to a tile more
    is read and written. Both arrays (m,) have the type of the coefficients `k` (n_lines n_taps,).

    n_together : 1 or 2, a literal
    at : where the first tap of the first number lies in `source`
    stride, step : numbers from a line to the next, from a tap to the next
    is_deep : whether any of the `levels` is not 0
    between : numbers from a row of results to the next
    """
    height = n_together.literal_value
    arguments = n_together, source, at, stride, step, n, k, starts, levels, is_deep, out, between
    return types.void(*arguments), partial(_generate_tiles, height)


def _generate_tiles(height: int, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Emit the loops over tiles, lines and groups, and the products and sums of a group of each length."""
    at, stride, step, n = arguments[2:6]
    is_deep, between = arguments[9], arguments[11]
    source, k, starts, levels, out = (
        context.make_array(signature.args[i])(context, builder, arguments[i]) for i in (1, 6, 7, 8, 10)
    )
    number, index = context.get_data_type(signature.args[1].dtype), ir.IntType(64)
    number_bytes = signature.args[1].dtype.bitwidth // 8
    n_lanes, n_vectors = VECTOR_BYTES // number_bytes, TILE_BYTES // VECTOR_BYTES
    vector = ir.VectorType(number, n_lanes)
    n_lines, n_groups = builder.extract_value(levels.shape, 0), builder.extract_value(levels.shape, 1)
    zero, one = ir.Constant(index, 0), ir.Constant(index, 1)

    def find_vectors(pointer: Any) -> list[Any]:
        parts = (builder.gep(pointer, [ir.Constant(index, n_lanes * i)]) for i in range(n_vectors))
        return [builder.bitcast(part, ir.PointerType(vector)) for part in parts]

    def load(pointers: list[Any]) -> list[Any]:
        values = [builder.load(pointer) for pointer in pointers]
        for value in values:
            value.align = number_bytes  # rows may begin anywhere
        return values

    def store(values: list[Any], pointers: list[Any]) -> None:
        for value, pointer in zip(values, pointers, strict=True):
            builder.store(value, pointer).align = number_bytes

    def repeat(value: Any) -> Any:
        nothing = ir.Constant(vector, ir.Undefined)
        first = builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
        order = ir.Constant(ir.VectorType(ir.IntType(32), n_lanes), [0] * n_lanes)
        return builder.shuffle_vector(first, nothing, order)

    def add(a: list[Any], b: list[Any]) -> list[Any]:
        return [builder.fadd(*pair) for pair in zip(a, b, strict=True)]

    def clear(sums: list[Any]) -> None:
        store([ir.Constant(vector, [ir.Constant(number, 0.0)] * n_lanes)] * n_vectors, sums)

    def close(sums: list[list[Any]], level: int) -> None:
        store(add(load(sums[level + 1]), load(sums[level])), sums[level + 1])
        clear(sums[level])

    def add_line(pointer: Any, rows: list[tuple[list[list[Any]], Any]]) -> None:
        """Add the taps of a line at `pointer` to the sums of each of `rows`, to which it is the line that is named."""
        with cgutils.for_range(builder, n_groups, intp=index) as loop:
            first = builder.load(builder.gep(starts.data, [loop.index]))
            end = builder.load(builder.gep(starts.data, [builder.add(loop.index, one)]))
            n_taps = builder.load(builder.gep(starts.data, [n_groups]))
            begin = builder.gep(pointer, [builder.mul(first, step)])
            coefficients = [builder.gep(k.data, [builder.add(builder.mul(line, n_taps), first)]) for _, line in rows]
            after = builder.append_basic_block("after_group")
            choice = builder.switch(builder.sub(end, first), after)
            for length in range(1, MAX_GROUP + 1):
                block = builder.append_basic_block(f"group_of_{length}")
                choice.add_case(ir.Constant(index, length), block)
                with builder.goto_block(block):
                    totals: list[list[Any]] = []
                    for tap in range(length):
                        place = ir.Constant(index, tap)
                        numbers = load(find_vectors(builder.gep(begin, [builder.mul(step, place)])))
                        factors = [repeat(builder.load(builder.gep(each, [place]))) for each in coefficients]
                        products = [[builder.fmul(factor, value) for value in numbers] for factor in factors]
                        totals = [add(*pair) for pair in zip(totals, products, strict=True)] if tap else products
                    for (sums, _), total in zip(rows, totals, strict=True):
                        store(add(load(sums[0]), total), sums[0])
                    builder.branch(after)
            builder.position_at_end(after)
            with builder.if_then(is_deep, likely=False):
                for sums, line in rows:
                    group = builder.add(builder.mul(line, n_groups), loop.index)
                    level = builder.load(builder.gep(levels.data, [group]))
                    for lower in range(2):
                        is_closed = builder.icmp_unsigned(">", level, ir.Constant(level.type, lower))
                        with builder.if_then(is_closed, likely=False):
                            close(sums, lower)

    # Of three levels, for each row; they become registers.
    rows = [[[cgutils.alloca_once(builder, vector) for _ in range(n_vectors)] for _ in range(3)] for _ in range(height)]
    tile = ir.Constant(index, TILE_BYTES // number_bytes)
    with cgutils.for_range_slice(builder, zero, n, tile, index) as (x, _):
        begin = builder.gep(source.data, [builder.add(at, x)])
        for sums in rows:
            for level in sums:
                clear(level)
        if height == 2:
            add_line(begin, [(rows[0], zero)])
        with cgutils.for_range(builder, n_lines, start=ir.Constant(index, height - 1), intp=index) as loop:
            members = [(sums, builder.sub(loop.index, ir.Constant(index, i))) for i, sums in enumerate(rows)]
            add_line(builder.gep(begin, [builder.mul(loop.index, stride)]), members)
        if height == 2:
            add_line(builder.gep(begin, [builder.mul(n_lines, stride)]), [(rows[1], builder.sub(n_lines, one))])
        for i, sums in enumerate(rows):
            with builder.if_then(is_deep, likely=False):
                close(sums, 0)
                close(sums, 1)
                store(load(sums[2]), sums[0])
            place = builder.add(x, builder.mul(between, ir.Constant(index, i)))
            store(load(sums[0]), find_vectors(builder.gep(out.data, [place])))
    return context.get_dummy_value()


@compile_function
def correlate_row(
    source: Array,
    at: int,
    stride: int,
    step: int,
    n: int,
    k: Array,
    starts: Array,
    levels: Array,
    is_deep: bool,
    out: Array,
) -> None:
    """Write the sums of one row, as `correlate_tiles` does."""
    correlate_tiles(1, source, at, stride, step, n, k, starts, levels, is_deep, out, 0)


@compile_function
def correlate_two_rows(
    source: Array,
    at: int,
    stride: int,
    step: int,
    n: int,
    k: Array,
    starts: Array,
    levels: Array,
    is_deep: bool,
    out: Array,
    between: int,
) -> None:
    """Write the sums of two rows, as `correlate_tiles` does."""
    correlate_tiles(2, source, at, stride, step, n, k, starts, levels, is_deep, out, between)


@compile_function
def read_row(
    image: Array, columns: Array, first: int, left: int, n_channels: int, zero: Any, premultiplies: bool, out: Array
) -> None:
    """Write the pixels of a row of an image (w c,) that `columns` names, from `first` on, into `out`, in its own type.

    left : how many of `columns` come before the image, which stands whole after them; -1 there stands for zeros
    """
    n_pixels, width = len(out) // n_channels, len(image) // n_channels
    start = min(max(left - first, 0), n_pixels)
    end = min(max(left + width - first, start), n_pixels)
    offset = (first + start - left) * n_channels
    inner, target = image[offset : offset + (end - start) * n_channels], out[start * n_channels : end * n_channels]
    for x in range(len(target)):
        target[x] = out.dtype.type(inner[x]) - zero
    for side in range(2):
        for pixel in range(end if side else 0, n_pixels if side else start):
            column = columns[first + pixel]
            for channel in range(n_channels):
                value = out.dtype.type(0)
                if column >= 0:
                    value = out.dtype.type(image[column * n_channels + channel])
                out[pixel * n_channels + channel] = value - zero
    if premultiplies:
        for pixel in range(n_pixels):
            alpha = out[4 * pixel + 3]
            out[4 * pixel] *= alpha
            out[4 * pixel + 1] *= alpha
            out[4 * pixel + 2] *= alpha


@compile_function
def unpremultiply(sums: Array, opaque: Any) -> None:
    """Divide colours by alpha, as `unpremultiply` in wgsl/shared/pixel_format.wgsl."""
    zero, one = sums.dtype.type(0), sums.dtype.type(1)
    for pixel in range(len(sums) // 4):
        red, green, blue, alpha = sums[4 * pixel], sums[4 * pixel + 1], sums[4 * pixel + 2], sums[4 * pixel + 3]
        # Chosen before they are divided, so that the compiler divides several at once.
        is_seen = alpha > zero
        divisor = min(alpha, opaque) if is_seen else one
        sums[4 * pixel] = (red if is_seen else zero) / divisor
        sums[4 * pixel + 1] = (green if is_seen else zero) / divisor
        sums[4 * pixel + 2] = (blue if is_seen else zero) / divisor
        sums[4 * pixel + 3] = divisor if is_seen else zero


@compile_function
def write_row(sums: Array, out: Array, scale: Any, opaque: Any, fraction: Any, whole: Any, largest: Any) -> None:
    """Write sums (n,) as pixels: scaled, divided by alpha if `opaque` is not 0, and rounded if `largest` is not."""
    if largest == 0 and opaque == 0:
        for x in range(len(sums)):
            out[x] = sums[x] * scale
        return
    for x in range(len(sums)):
        sums[x] *= scale
    if opaque > 0:
        unpremultiply(sums, opaque)
    if largest > 0:
        for x in range(len(sums)):
            out[x] = out.dtype.type(min(max(np.rint(sums[x] + fraction) + whole, sums.dtype.type(0)), largest))
    else:
        for x in range(len(sums)):
            out[x] = sums[x]


@compile_loop
def correlate(
    images: Array,
    rows: Array,
    columns: Array,
    n_channels: int,
    left: int,
    k: Array,
    starts: Array,
    levels: Array,
    is_column: bool,
    k_second: Array,
    starts_second: Array,
    levels_second: Array,
    numbers: Array,
    is_premultiplied: bool,
    out: Array,
    rows_per_band: int,
    pixels_per_block: int,
    windows: Array,
    scratch: Array,
) -> None:
    """Write images (k, h, w c), through one pass or through another of a column as well, into `out`.

    rows, columns : which row, which column stands where, from the first that a tap meets; -1 for zeros
    left : how many columns come before the image
    k, starts, levels : coefficients (n_lines n_taps,), and how `TapGroups` groups them; of a second pass as well, which
        has no taps if there is none
    numbers : zero, scale, opaque, the offset's fraction and whole, the largest integer or 0, in the type of the sums
    windows : how many rows of the image are kept, and of the first pass's results, and how many numbers lie between
        rows of these and of those
    scratch : (n_workers, m) of the type of the sums, for both windows and two rows: fresh memory costs more than sums
    """
    height, width = images.shape[1], images.shape[2] // n_channels
    n_bands = (height + rows_per_band - 1) // rows_per_band
    n_tasks, n_workers = len(images) * n_bands, len(scratch)
    zero, scale, opaque, fraction, whole, largest = numbers
    beside = len(columns) - width
    above_second = max(len(k_second) - 1, 0)
    above_first = len(rows) - height - above_second
    has_second = len(k_second) > 0
    capacity, capacity_second, stride, stride_second = windows
    n_kept = above_first + 1  # rows of a full window that two rows of results may need again
    shares_lines = len(levels) > 1 and not has_second
    is_deep, is_deep_second = bool(levels.any()), bool(levels_second.any())
    tap_step = int(stride if is_column else n_channels)
    for worker in numba.prange(n_workers):
        source = scratch[worker, : capacity * stride]
        middle = scratch[worker, len(source) : len(source) + capacity_second * stride_second]
        sums = scratch[worker, len(source) + len(middle) :]
        for task in range(worker * n_tasks // n_workers, (worker + 1) * n_tasks // n_workers):
            image, target = images[task // n_bands], out[task // n_bands]
            top = (task % n_bands) * rows_per_band
            for first in range(0, width, pixels_per_block):
                n = min(pixels_per_block, width - first) * n_channels
                # Both windows hold the rows from `begin` on, of those that were read or made.
                n_read = begin = n_made = begin_second = 0
                n_rows, y = min(rows_per_band, height - top), 0
                while y < n_rows:
                    n_together = 2 if shares_lines and y + 1 < n_rows else 1
                    while n_made < y + n_together + above_second:
                        while n_read <= n_made + above_first:
                            if n_read - begin == capacity:
                                source[: n_kept * stride] = source[(capacity - n_kept) * stride :]
                                begin = n_read - n_kept
                            at = (n_read - begin) * stride
                            row = source[at : at + n + beside * n_channels]
                            place = rows[top + n_read]
                            if place < 0:
                                row[:] = -zero
                            else:
                                read_row(image[place], columns, first, left, n_channels, zero, is_premultiplied, row)
                            n_read += 1
                        if has_second:
                            if n_made - begin_second == capacity_second:
                                kept = (capacity_second - above_second) * stride_second
                                middle[: above_second * stride_second] = middle[kept:]
                                begin_second = n_made - above_second
                            at = (n_made - begin) * stride
                            made = middle[(n_made - begin_second) * stride_second :]
                            correlate_row(source, at, stride, tap_step, n, k, starts, levels, is_deep, made)
                        n_made += 1
                    at = (y - begin) * stride
                    if has_second:
                        at = (y - begin_second) * stride_second
                        correlate_row(
                            middle,
                            at,
                            stride_second,
                            stride_second,
                            n,
                            k_second,
                            starts_second,
                            levels_second,
                            is_deep_second,
                            sums,
                        )
                    elif n_together == 1:
                        correlate_row(source, at, stride, tap_step, n, k, starts, levels, is_deep, sums)
                    else:
                        correlate_two_rows(
                            source, at, stride, tap_step, n, k, starts, levels, is_deep, sums, stride_second
                        )
                    for lower in range(n_together):
                        row_out = target[top + y + lower, first * n_channels : first * n_channels + n]
                        result = sums[lower * stride_second : lower * stride_second + n]
                        write_row(result, row_out, scale, opaque, fraction, whole, largest)
                    y += n_together
