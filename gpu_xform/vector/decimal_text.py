"""Fixed-point numbers as decimal text: NumPy writes the digits of all rows at once."""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Bytes: TypeAlias = npt.NDArray[np.uint8]
FixedPoint: TypeAlias = npt.NDArray[np.int32]
Column: TypeAlias = bytes | npt.NDArray[Any]

ROWS_PER_CHUNK = 1 << 15  # their digits stay in a cache


def to_fixed_point(pixels: npt.NDArray[np.floating[Any]]) -> FixedPoint:
    """Return `pixels` in hundredths of a pixel, rounded to integers."""
    return np.rint(pixels.astype(np.float64) * 100.0).astype(np.int32)


def format_rows(*columns: Column) -> tuple[bytes, npt.NDArray[np.int64]]:
    """Return the text of all rows, and the offset at which each row begins in it, with the end after the last.

    columns : bytes that are the same in all rows, or an array with an element per row: hundredths, written as pixels
        with at most two decimals and no trailing zeros, or byte strings
    """
    n = next(len(column) for column in columns if not isinstance(column, bytes))
    texts, lengths = [], [np.zeros(1, np.int64)]
    for start in range(0, n, ROWS_PER_CHUNK):
        end = min(start + ROWS_PER_CHUNK, n)
        parts = [column if isinstance(column, bytes) else column[start:end] for column in columns]
        characters = np.hstack([_to_characters(part, end - start) for part in parts])
        is_used = characters != 0
        texts.append(characters[is_used].tobytes())
        lengths.append(is_used.sum(axis=1))
    return b"".join(texts), np.cumsum(np.concatenate(lengths))


def _to_characters(column: Column, n: int) -> Bytes:
    """Return `n` rows of a column as characters (n, k), 0 after the end of shorter rows."""
    if isinstance(column, bytes):
        return np.broadcast_to(np.frombuffer(column, np.uint8), (n, len(column)))
    if column.dtype.kind == "S":
        return np.ascontiguousarray(column).view(np.uint8).reshape(n, -1)
    return _format_decimals(column)


def _format_decimals(values: FixedPoint) -> Bytes:
    magnitudes = np.abs(values)
    n_digits = max(len(str(magnitudes.max(initial=0))), 3)
    characters = np.zeros((len(values), n_digits + 2), np.uint8)  # sign, digits, and a point before the last two
    characters[values < 0, 0] = ord("-")
    rest = magnitudes
    for place in range(n_digits):
        rest, digit = np.divmod(rest, 10)
        character = digit.astype(np.uint8) + ord("0")
        if place == 0:
            is_needed = digit != 0
        elif place == 1:
            is_needed |= digit != 0
            characters[is_needed, -3] = ord(".")
        else:
            is_needed = magnitudes >= 10**place if place > 2 else np.True_
        characters[:, -1 - place - (place > 1)] = np.where(is_needed, character, 0)
    return characters
