"""The loops of convolution on the host: images through lines of taps, band by band.

A pass has `n_lines` lines of `n_taps` taps: a matrix is its rows, a column one line. The taps of a line are added in
groups, and groups in the order of `tap_groups.py`, so that neither bands nor blocks of columns nor
the number of threads changes a byte. No tap is added that the matrix does not have, nor contracted with its product.
"""

from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from .compile import compile_function, compile_loop

Array = npt.NDArray[Any]


# Sums of one line, as a function per number of taps, so that the compiler sees no inner loop: `out` from `at` on gains
# the products of coefficients `k` from `i` on and of `n` numbers of `source` from `o` on, tap by tap `step` further.
# All of these are unsigned: numbers that an index below 0 might mean are gathered one by one. Parts of arrays would do
# as well, but each costs as much as fifty sums.

ZERO, ONE, TWO, THREE, FOUR = (np.uint64(number) for number in range(5))


@compile_function
def add_1(source: Array, o: Any, n: Any, k: Array, i: Any, out: Array, at: Any) -> None:
    """Add one tap."""
    a = k[i]
    for x in range(n):
        out[at + x] += a * source[o + x]


@compile_function
def add_3(source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, out: Array, at: Any) -> None:
    """Add three taps."""
    a, b, c = k[i], k[i + ONE], k[i + TWO]
    o1 = o + step
    o2 = o1 + step
    for x in range(n):
        out[at + x] += a * source[o + x] + b * source[o1 + x] + c * source[o2 + x]


@compile_function
def add_4(source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, out: Array, at: Any) -> None:
    """Add four taps."""
    a, b, c, d = k[i], k[i + ONE], k[i + TWO], k[i + THREE]
    o1 = o + step
    o2 = o1 + step
    o3 = o2 + step
    for x in range(n):
        out[at + x] += a * source[o + x] + b * source[o1 + x] + c * source[o2 + x] + d * source[o3 + x]


@compile_function
def add_5(source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, out: Array, at: Any) -> None:
    """Add five taps."""
    a, b, c, d, e = k[i], k[i + ONE], k[i + TWO], k[i + THREE], k[i + FOUR]
    o1 = o + step
    o2 = o1 + step
    o3 = o2 + step
    o4 = o3 + step
    for x in range(n):
        out[at + x] += (
            a * source[o + x] + b * source[o1 + x] + c * source[o2 + x] + d * source[o3 + x] + e * source[o4 + x]
        )


# The same for two rows of results at once, which read a row of the image once: `j` is the place of the coefficients
# of the lower one, and `lower` its own.


@compile_function
def add_1_to_two(source: Array, o: Any, n: Any, k: Array, i: Any, j: Any, out: Array, at: Any, lower: Any) -> None:
    """Add one tap to each."""
    a = k[i]
    a_lower = k[j]
    for x in range(n):
        p = source[o + x]
        out[at + x] += a * p
        out[lower + x] += a_lower * p


@compile_function
def add_3_to_two(
    source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, j: Any, out: Array, at: Any, lower: Any
) -> None:
    """Add three taps to each."""
    a, b, c = k[i], k[i + ONE], k[i + TWO]
    a_lower, b_lower, c_lower = k[j], k[j + ONE], k[j + TWO]
    o1 = o + step
    o2 = o1 + step
    for x in range(n):
        p, q, r = source[o + x], source[o1 + x], source[o2 + x]
        out[at + x] += a * p + b * q + c * r
        out[lower + x] += a_lower * p + b_lower * q + c_lower * r


@compile_function
def add_4_to_two(
    source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, j: Any, out: Array, at: Any, lower: Any
) -> None:
    """Add four taps to each."""
    a, b, c, d = k[i], k[i + ONE], k[i + TWO], k[i + THREE]
    a_lower, b_lower, c_lower, d_lower = (
        k[j],
        k[j + ONE],
        k[j + TWO],
        k[j + THREE],
    )
    o1 = o + step
    o2 = o1 + step
    o3 = o2 + step
    for x in range(n):
        p, q, r, y = source[o + x], source[o1 + x], source[o2 + x], source[o3 + x]
        out[at + x] += a * p + b * q + c * r + d * y
        out[lower + x] += a_lower * p + b_lower * q + c_lower * r + d_lower * y


@compile_function
def add_5_to_two(
    source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, j: Any, out: Array, at: Any, lower: Any
) -> None:
    """Add five taps to each."""
    a, b, c, d, e = k[i], k[i + ONE], k[i + TWO], k[i + THREE], k[i + FOUR]
    a_lower, b_lower, c_lower, d_lower, e_lower = (
        k[j],
        k[j + ONE],
        k[j + TWO],
        k[j + THREE],
        k[j + FOUR],
    )
    o1 = o + step
    o2 = o1 + step
    o3 = o2 + step
    o4 = o3 + step
    for x in range(n):
        p, q, r, y, z = source[o + x], source[o1 + x], source[o2 + x], source[o3 + x], source[o4 + x]
        out[at + x] += a * p + b * q + c * r + d * y + e * z
        out[lower + x] += a_lower * p + b_lower * q + c_lower * r + d_lower * y + e_lower * z


@compile_function
def add_group(n_taps: int, source: Array, o: Any, step: Any, n: Any, k: Array, i: Any, out: Array, at: Any) -> None:
    """Add a group of taps."""
    if n_taps == 1:
        add_1(source, o, n, k, i, out, at)
    elif n_taps == 3:
        add_3(source, o, step, n, k, i, out, at)
    elif n_taps == 4:
        add_4(source, o, step, n, k, i, out, at)
    else:
        add_5(source, o, step, n, k, i, out, at)


@compile_function
def add_group_to_two(
    n_taps: int,
    source: Array,
    o: Any,
    step: Any,
    n: Any,
    k: Array,
    i: Any,
    j: Any,
    out: Array,
    at: Any,
    lower: Any,
) -> None:
    """Add a group of taps to each of two rows."""
    if n_taps == 1:
        add_1_to_two(source, o, n, k, i, j, out, at, lower)
    elif n_taps == 3:
        add_3_to_two(source, o, step, n, k, i, j, out, at, lower)
    elif n_taps == 4:
        add_4_to_two(source, o, step, n, k, i, j, out, at, lower)
    else:
        add_5_to_two(source, o, step, n, k, i, j, out, at, lower)


# Sums of rows are (6 size,) numbers: of two rows of results, each with sums of three levels, `size` numbers apart.


@compile_function
def close_sums(sums: Array, at: Any, size: Any, n: Any, level: int) -> None:
    """Add the finished sums of a row, from `at` on, to those of the next level, up to `level`, and begin them anew."""
    for _ in range(level):
        above = at + size
        for x in range(n):
            sums[above + x] += sums[at + x]
            sums[at + x] = 0
        at = above


@compile_function
def correlate_rows(
    source: Array,
    o: Any,
    stride: Any,
    step: Any,
    n: Any,
    k: Array,
    starts: Array,
    levels: Array,
    sums: Array,
    size: Any,
    n_together: int,
) -> None:
    """Sum the taps of one row of results, or of two: the lower one meets each row of the image a line earlier.

    k : (n_lines n_taps,)
    stride : numbers from the row of the image that a line reads to that of the next
    """
    n_lines = len(levels)
    n_taps = starts[-1]
    lower = size + size + size
    for reached in range(n_lines + n_together - 1):
        is_shared = n_together == 2 and 0 < reached < n_lines
        # If one of the two rows of results is by itself, which, and the line that it has reached.
        is_lower = reached == n_lines
        at, line = (lower, reached - 1) if is_lower else (ZERO, reached)
        row = o + np.uint64(reached) * stride
        for group in range(len(starts) - 1):
            first, end = starts[group], starts[group + 1]
            i, part = np.uint64(line * n_taps + first), row + np.uint64(first) * step
            if is_shared:
                j = np.uint64((line - 1) * n_taps + first)
                add_group_to_two(end - first, source, part, step, n, k, i, j, sums, ZERO, lower)
                close_sums(sums, lower, size, n, levels[line - 1, group])
            else:
                add_group(end - first, source, part, step, n, k, i, sums, at)
            close_sums(sums, at, size, n, levels[line, group])


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
) -> None:
    """Write images (k, h, w c), through one pass or through another of a column as well, into `out`.

    rows, columns : which row, which column stands where, from the first that a tap meets; -1 for zeros
    left : how many columns come before the image
    k, starts, levels : coefficients (n_lines n_taps,), and how `TapGroups` groups them; of a second pass as well, which
        has no taps if there is none
    numbers : zero, scale, opaque, the offset's fraction and whole, the largest integer or 0, in the type of the sums
    """
    height, width = images.shape[1], images.shape[2] // n_channels
    n_bands = (height + rows_per_band - 1) // rows_per_band
    zero, scale, opaque, fraction, whole, largest = numbers
    above, beside = len(rows) - height, len(columns) - width
    above_second = max(len(k_second) - 1, 0)
    # No multiple of a page, at which rows would share the lines of a cache.
    stride = (pixels_per_block + beside) * n_channels + 16
    stride_second = pixels_per_block * n_channels + 16
    has_second = len(k_second) > 0
    has_levels = levels.any() or levels_second.any()
    for task in numba.prange(len(images) * n_bands):
        image, target = images[task // n_bands], out[task // n_bands]
        top = (task % n_bands) * rows_per_band
        n_rows = min(rows_per_band, height - top)
        source = np.empty((n_rows + above) * stride, k.dtype)
        middle = np.empty((n_rows + above_second) * stride_second if has_second else 0, k.dtype)
        size = pixels_per_block * n_channels + 80
        sums = np.zeros(6 * size, k.dtype)
        for first in range(0, width, pixels_per_block):
            n = min(pixels_per_block, width - first) * n_channels
            n_read, reach = 0, above - above_second
            numbers_made = np.uint64(n)
            for number in range(2 if has_second else 1):
                is_last = number == 1 or not has_second
                start = middle if number else source
                taps = k_second if number else k
                groups = starts_second if number else starts
                closes = levels_second if number else levels
                row_stride = np.uint64(stride_second if number else stride)
                step = row_stride if number or is_column else np.uint64(n_channels)
                n_made = n_rows if is_last else n_rows + above_second
                y = 0
                while y < n_made:
                    n_together = 2 if len(closes) > 1 and y + 1 < n_made else 1
                    sums[:n] = 0
                    sums[3 * size : 3 * size + n] = 0
                    if number == 0:  # rows are read when they are needed, so that the memory works meanwhile
                        while n_read < y + n_together + reach:
                            row = source[n_read * stride : n_read * stride + n + beside * n_channels]
                            place = rows[top + n_read]
                            if place < 0:
                                row[:] = -zero
                            else:
                                read_row(image[place], columns, first, left, n_channels, zero, is_premultiplied, row)
                            n_read += 1
                    at = np.uint64(y) * row_stride
                    unsigned_size = np.uint64(size)
                    correlate_rows(
                        start, at, row_stride, step, numbers_made, taps, groups, closes, sums, unsigned_size, n_together
                    )
                    for k_row in range(n_together):
                        begin = 3 * size * k_row
                        if has_levels:
                            close_sums(sums, np.uint64(begin), unsigned_size, numbers_made, 2)
                            sums[begin : begin + n] = sums[begin + 2 * size : begin + 2 * size + n]
                            sums[begin + 2 * size : begin + 2 * size + n] = 0
                        result = sums[begin : begin + n]
                        if is_last:
                            row_out = target[top + y + k_row, first * n_channels : first * n_channels + n]
                            write_row(result, row_out, scale, opaque, fraction, whole, largest)
                        else:
                            middle[(y + k_row) * stride_second : (y + k_row) * stride_second + n] = result
                    y += n_together
