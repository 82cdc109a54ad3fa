"""Coordinates as decimal text, in bulk: NumPy writes the digits."""

from typing import Any

import numpy as np
import numpy.typing as npt

Octets = npt.NDArray[np.uint8]
Hundredths = npt.NDArray[np.int32]
Piece = bytes | npt.NDArray[Any]

_ROWS_AT_ONCE = 1 << 15  # their digits stay in a cache


def hundredths(pixels: npt.NDArray[np.floating[Any]]) -> Hundredths:
    """Return `pixels` rounded to hundredths, as whole numbers of them."""
    return np.rint(pixels.astype(np.float64) * 100.0).astype(np.int32)


def rows(*pieces: Piece) -> tuple[bytes, npt.NDArray[np.int64]]:
    """Return the text of all rows, and where each row begins in it, with the end after the last.

    Each piece is the same in all rows, or an array with something for each row: hundredths, which become pixels with at
    most two decimals and no zero too many, or words.
    """
    n = next(len(piece) for piece in pieces if not isinstance(piece, bytes))
    texts, lengths = [], [np.zeros(1, np.int64)]
    for start in range(0, n, _ROWS_AT_ONCE):
        end = min(start + _ROWS_AT_ONCE, n)
        columns = [piece if isinstance(piece, bytes) else piece[start:end] for piece in pieces]
        octets = np.hstack([_octets(column, end - start) for column in columns])
        used = octets != 0
        texts.append(octets[used].tobytes())
        lengths.append(used.sum(axis=1))
    return b"".join(texts), np.cumsum(np.concatenate(lengths))


def _octets(piece: Piece, n: int) -> Octets:
    """Return a piece of `n` rows as characters (n, k), 0 where a row is shorter."""
    if isinstance(piece, bytes):
        return np.broadcast_to(np.frombuffer(piece, np.uint8), (n, len(piece)))
    if piece.dtype.kind == "S":
        return np.ascontiguousarray(piece).view(np.uint8).reshape(n, -1)
    return _decimals(piece)


def _decimals(values: Hundredths) -> Octets:
    magnitudes = np.abs(values)
    n_digits = max(len(str(magnitudes.max(initial=0))), 3)
    octets = np.zeros((len(values), n_digits + 2), np.uint8)  # sign, digits, and a point before the last two
    octets[values < 0, 0] = ord("-")
    left = magnitudes
    for place in range(n_digits):
        left, digit = np.divmod(left, 10)
        character = digit.astype(np.uint8) + ord("0")
        if place == 0:
            needed = digit != 0
        elif place == 1:
            needed |= digit != 0
            octets[needed, -3] = ord(".")
        else:
            needed = magnitudes >= 10**place if place > 2 else np.True_
        octets[:, -1 - place - (place > 1)] = np.where(needed, character, 0)
    return octets
