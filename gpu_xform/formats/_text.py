"""Numbers to and from text: in bulk through NumPy, and one word at a time where an error must name its line."""

import warnings
from collections.abc import Callable
from typing import Any, BinaryIO, Literal, overload

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh

_SENTINEL = 4611686018427388027  # an odd number that no file holds, and that float64 rounds to 2**62
_ROWS_AT_ONCE = 1 << 16


@overload
def parse(text: bytes, kind: Literal["float"]) -> Float64Array: ...
@overload
def parse(text: bytes, kind: Literal["int"]) -> IndexArray: ...
def parse(text: bytes, kind: Literal["float", "int"]) -> npt.NDArray[Any]:
    """Return the numbers of `text`, which whitespace separates; raise ValueError if it holds anything else.

    An integer beyond int64 becomes the largest one, a float beyond float64 an infinity.
    """
    dtype = np.float64 if kind == "float" else np.int64
    if kind == "int" and _has_lone_sign(text):
        raise ValueError("a sign without a number")
    # NumPy only warns where it stops early, and filters are not safe under threads: the sentinel must come out last.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            values = np.fromstring(text + b" %d" % _SENTINEL, dtype, sep=" ")
        except DeprecationWarning:
            values = np.empty(0, dtype)
    if len(values) == 0 or values[-1] != dtype(_SENTINEL):
        raise ValueError("not a number")
    return values[:-1]


def _has_lone_sign(text: bytes) -> bool:
    """Tell whether whitespace follows a sign: NumPy would take the number behind it."""
    blanks = [blank for blank in (b" ", b"\n", b"\t", b"\r", b"\v", b"\f") if blank in text]
    signs = [sign for sign in (b"-", b"+") if sign in text]
    return any(sign + blank in text for sign in signs for blank in blanks)


def printable(word: bytes | str) -> str:
    """Quote a piece of a file for an error message, cut to a readable length."""
    text = word.decode("latin-1") if isinstance(word, bytes) else word
    return repr(text if len(text) <= 40 else text[:37] + "...")


def number(word: bytes | str, line: int) -> float:
    """Return the number that a word is; raise MeshError with its line for another word."""
    try:
        if _is_grouped(word):
            raise ValueError
        return float(word)
    except ValueError:
        raise MeshError(f"line {line}: expected a number, got {printable(word)}") from None


def integer(word: bytes | str, line: int, base: int = 10) -> int:
    """Return the integer that a word is, held within int64; raise MeshError with its line for another word."""
    try:
        if _is_grouped(word):
            raise ValueError
        value = int(word, base)
    except ValueError:
        raise MeshError(f"line {line}: expected an integer, got {printable(word)}") from None
    return max(-(2**63), min(value, 2**63 - 1))


def _is_grouped(word: bytes | str) -> bool:
    """Tell whether a word has underscores between digits, as only Python reads them."""
    return b"_" in word if isinstance(word, bytes) else "_" in word


def write_points(file: BinaryIO, template: bytes, mesh: Mesh) -> None:
    """Write one line a point, with the shortest decimals that give the same float64 back."""
    for start in range(0, mesh.n_points, _ROWS_AT_ONCE):
        rows = mesh.positions[start : start + _ROWS_AT_ONCE]
        file.write((template * len(rows)) % tuple(rows.ravel().tolist()))


def write_faces(file: BinaryIO, template: Callable[[int], bytes], mesh: Mesh, first: int) -> None:
    """Write one line a face, its template chosen by its number of corners, its indices counted from `first`."""
    sizes = np.diff(mesh.offsets)
    templates = {size: template(size) for size in np.unique(sizes).tolist()}
    for start in range(0, mesh.n_faces, _ROWS_AT_ONCE):
        end = min(start + _ROWS_AT_ONCE, mesh.n_faces)
        corners = mesh.indices[mesh.offsets[start] : mesh.offsets[end]] + first
        file.write(b"".join(map(templates.__getitem__, sizes[start:end].tolist())) % tuple(corners.tolist()))
