"""Arrays for a page: integers as planes of bytes, which compress well, and floats; `js/arrays.js` reads them.

Bytes become text of two digits of base 91 per 13 bits, a fourteenth shorter than in base 64: `page.html` reads that.
"""

import json
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .short_names import ShortNames

LEVEL = 9
MAX_SIZE_TRIED = 1 << 18  # numbers; of more, a quick compressor says which coding is the shortest
RADIX, WORD_BITS = 91, 13
FIRST_DIGIT = ord("#")  # the digits follow in their order up to "}", so that no text ends a script,
LESS_THAN, STANDS_IN = ord("<"), ord("~")  # but for one that could open a comment


class ArrayStore:
    """Arrays that a page holds, each named by its number."""

    def __init__(self) -> None:
        self._layouts: list[dict[str, Any]] = []
        self._parts: list[bytes] = []

    def add_integers(self, values: npt.NDArray[Any]) -> int:
        """Return the number of integers (n,) or (n, columns), taken modulo 2**32, in the shortest coding."""
        return self._add_coded(_code(_as_words(values)))

    def add_indices(self, values: npt.NDArray[Any]) -> int:
        """Return the number of integers (n,) or (n, columns), of which most come again soon.

        Where that is shorter, they are stored as how far back each was last, row by row, 0 for those that are new; and
        those in an array of their own.
        """
        words = _as_words(values)
        distances, new = _find_again(words)
        plain, again, first = _code(words), _code(distances, ("plain",)), _code(new[np.newaxis])
        if plain.n_compressed <= again.n_compressed + first.n_compressed:
            return self._add_coded(plain)
        return self._add_coded(replace(again, coding="again"), new=self._add_coded(first))

    def _add_coded(self, coded: "_Coded", **more: int) -> int:
        columns, n = coded.shape
        return self._add(coded.content, n=n, columns=columns, bytes=coded.n_bytes, coding=coded.coding, **more)

    def add_floats(self, values: npt.NDArray[np.float64]) -> int:
        """Return the number of floats (n, columns)."""
        columns = np.ascontiguousarray(values.T, "<f8")
        planes = columns.reshape(-1).view(np.uint8).reshape(-1, 8).T.tobytes()
        return self._add(planes, n=values.shape[0], columns=values.shape[1], bytes=8, isFloat=True)

    def _add(self, content: bytes, **layout: Any) -> int:
        self._layouts.append(layout)
        self._parts.append(content)
        return len(self._parts) - 1

    def encode(self, content: dict[str, Any], names: ShortNames | None = None) -> str:
        """Return the text, as `encode_bytes` makes it, of what a page holds: `content` as JSON, and the arrays.

        names : of the keys; None for those that are given
        """
        data = {**content, "arrays": self._layouts}
        head = json.dumps(names.rename_keys(data) if names else data, separators=(",", ":")).encode()
        return encode_bytes(struct.pack("<I", len(head)) + head + b"".join(self._parts))


def encode_bytes(content: bytes) -> str:
    """Return bytes compressed, as two digits of base 91 per 13 bits, first bits first.

    A decimal digit before them says how many of the last bytes are padding.
    """
    packed = zlib.compress(content, LEVEL)
    n_words = -(-8 * len(packed) // WORD_BITS)
    rows = np.zeros(
        (-(-n_words // 8), WORD_BITS + 1), np.uint32
    )  # eight words each, and a byte more to read at the end
    padded = np.frombuffer(packed + bytes(-len(packed) % WORD_BITS), np.uint8)
    rows[:, :WORD_BITS] = padded.reshape(-1, WORD_BITS)
    words = np.empty((len(rows), 8), np.uint32)
    for k in range(8):
        first, n_before = divmod(WORD_BITS * k, 8)
        three = (rows[:, first] << 16) | (rows[:, first + 1] << 8) | rows[:, first + 2]
        words[:, k] = (three >> (24 - WORD_BITS - n_before)) & ((1 << WORD_BITS) - 1)
    digits = np.stack(np.divmod(words.ravel()[:n_words], np.uint32(RADIX)), axis=1)
    text = digits.astype(np.uint8) + np.uint8(FIRST_DIGIT)
    text[text == LESS_THAN] = STANDS_IN
    return str(n_words * WORD_BITS // 8 - len(packed)) + text.tobytes().decode("ascii")


@dataclass(frozen=True)
class _Coded:
    """Integers as planes of bytes.

    shape : columns, rows
    n_compressed : bytes, about
    """

    coding: str
    shape: tuple[int, ...]
    n_bytes: int
    content: bytes
    n_compressed: int


def _as_words(values: npt.NDArray[Any]) -> npt.NDArray[np.uint32]:
    """Return integers (n,) or (n, columns) as (columns, n), modulo 2**32."""
    table = np.atleast_2d(values.T).T if values.ndim == 1 else values
    return np.ascontiguousarray(table.T.astype(np.int64).astype(np.uint32))


def _code(words: npt.NDArray[np.uint32], codings: Sequence[str] | None = None) -> _Coded:
    """Return integers (columns, n) in the shortest of codings, of all if none are given."""
    level = LEVEL if words.size < MAX_SIZE_TRIED else 1

    def code(coding: str) -> _Coded:
        n_bytes, content = _split_planes(_CODINGS[coding](words))
        return _Coded(coding, words.shape, n_bytes, content, len(zlib.compress(content, level)))

    return min(map(code, codings or _CODINGS), key=lambda coded: coded.n_compressed)


def _find_again(words: npt.NDArray[np.uint32]) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32]]:
    """Return how far back each number (columns, n) was last, row by row, 0 for those that are new; and those."""
    numbers = words.T.ravel()
    order = np.argsort(numbers, kind="stable")
    is_again = np.zeros(len(order), np.bool_)
    is_again[1:] = numbers[order[1:]] == numbers[order[:-1]]
    distances = np.zeros(len(order), np.int64)
    distances[order[is_again]] = np.diff(order, prepend=0)[is_again]
    table = np.ascontiguousarray(distances.astype(np.uint32).reshape(words.T.shape).T)
    return table, numbers[distances == 0]


def _split_planes(words: npt.NDArray[np.uint32]) -> tuple[int, bytes]:
    """Return how many bytes the values (columns, n) need, and the planes of those bytes, lowest first."""
    n_bytes = max((int(words.max(initial=0)).bit_length() + 7) // 8, 1)
    planes = words.reshape(-1).astype("<u4").view(np.uint8).reshape(-1, 4)[:, :n_bytes]
    return n_bytes, planes.T.tobytes()


def _fold_signs(words: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
    """Return the numbers with the sign in the lowest bit, so that those near 0 need few bytes."""
    signed = words.view(np.int32)
    return ((signed << 1) ^ (signed >> 31)).view(np.uint32)


def _list_differences(words: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
    return _fold_signs(np.diff(words, axis=1, prepend=np.uint32(0)))


def _count_back(words: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
    """Return how far each number, row by row, lies below one above the largest before it: 0 for a new point."""
    numbers = words.T.ravel()
    above = np.concatenate([np.zeros(1, np.uint32), np.maximum.accumulate(numbers)[:-1] + np.uint32(1)])[: numbers.size]
    return _fold_signs(np.ascontiguousarray((above - numbers).reshape(words.T.shape).T))


_CODINGS: dict[str, Callable[[npt.NDArray[np.uint32]], npt.NDArray[np.uint32]]] = {
    "plain": lambda words: words,
    "signed": _fold_signs,
    "delta": _list_differences,
    "back": _count_back,
}
