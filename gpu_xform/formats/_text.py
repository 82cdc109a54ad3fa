"""Numbers to and from text: in bulk with NumPy, and one word at a time for errors that name a line."""

import re
import warnings
from collections.abc import Callable
from typing import Any, BinaryIO, Literal, overload

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh

_SENTINEL = 4611686018427388027  # an odd number that no file is expected to hold; float64 rounds it to 2**62
_ROWS_PER_WRITE = 1 << 16
_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
_TAIL_BYTES = 512
_MAX_SINGLE_FINDS = 1000
_MAX_PATH_LENGTH = 100  # in a message
# What Microsoft's printf made of infinities and NaNs before 2015, rounded to few digits too: 1.#INF, -1.#IND00, 1.#J.
_MICROSOFT = re.compile(rb"(?<![^\s,\[])([+-]?)1\.#(?:(INF)|IND|QNAN|SNAN|NAN|IO|QO|J|R)[0-9]*(?![^\s,\]}])")


def plain_text(data: bytes) -> bytes:
    r"""Return the text of a file as UTF-8 without a byte order mark, with "\n" as line ends.

    NULs and Ctrl-Zs behind the end are dropped. NaNs and infinities as Microsoft writes them, such as -1.#IND00, become
    words that Python and NumPy read: their "#" begins no comment.
    """
    data = without_mark(data)
    tail = data[-_TAIL_BYTES:]
    if b"\0" in tail or b"\x1a" in tail:
        data = data.rstrip(b"\0\x1a \t\r\n") + b"\n"
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if _may_hold_microsoft(data):
        data = _MICROSOFT.sub(lambda match: (match[1] or b"+") + (b"inf" if match[2] else b"nan"), data)
    return data


def _may_hold_microsoft(data: bytes) -> bool:
    """Return whether "1.#" is in a text: the search for one character is several times as fast as for three."""
    place = data.find(b"#")
    for _ in range(_MAX_SINGLE_FINDS):
        if place < 0:
            return False
        if data[max(place - 2, 0) : place] == b"1.":
            return True
        place = data.find(b"#", place + 1)
    return b"1.#" in data


def without_mark(data: bytes) -> bytes:
    """Return the bytes of a file without a byte order mark; text in UTF-16 becomes UTF-8."""
    if data.startswith(_UTF16_MARKS):
        return data.decode("utf-16", "replace").encode("utf-8", "replace")
    return data.removeprefix(_UTF8_MARK)


@overload
def parse_numbers(text: bytes, kind: Literal["float"]) -> Float64Array: ...
@overload
def parse_numbers(text: bytes, kind: Literal["int"]) -> IndexArray: ...
def parse_numbers(text: bytes, kind: Literal["float", "int"]) -> npt.NDArray[Any]:
    """Return the numbers in `text`, separated by whitespace; raise ValueError if it holds anything else.

    An integer beyond int64 becomes the largest int64, a float beyond float64 an infinity.
    """
    dtype = np.float64 if kind == "float" else np.int64
    if kind == "int" and _has_lone_sign(text):
        raise ValueError("a sign without a number")
    # NumPy merely warns if it stops early, and warning filters are not thread-safe: so the sentinel must come last.
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
    """Return whether whitespace follows a sign: NumPy would accept it with the next number."""
    blanks = [blank for blank in (b" ", b"\n", b"\t", b"\r", b"\v", b"\f") if blank in text]
    signs = [sign for sign in (b"-", b"+") if sign in text]
    return any(sign + blank in text for sign in signs for blank in blanks)


def quote(word: bytes | str) -> str:
    """Return a piece of a file in quotes for an error message, cut to a readable length."""
    text = word.decode("latin-1") if isinstance(word, bytes) else word
    return repr(text if len(text) <= 40 else text[:37] + "...")


def quote_end(name: str) -> str:
    """Return a path in quotes, cut at its beginning, for files that lie in one folder differ at the end."""
    return repr(name if len(name) <= _MAX_PATH_LENGTH else f"...{name[-_MAX_PATH_LENGTH:]}")


def parse_float(word: bytes | str, line: int) -> float:
    """Return a word as a float; raise MeshError with its line if it is not a number."""
    try:
        if _has_underscore(word):
            raise ValueError
        return float(word)
    except ValueError:
        raise MeshError(f"line {line}: expected a number, got {quote(word)}") from None


def parse_int(word: bytes | str, line: int, base: int = 10) -> int:
    """Return a word as an integer, clamped to int64; raise MeshError with its line if it is not an integer."""
    try:
        if _has_underscore(word):
            raise ValueError
        value = int(word, base)
    except ValueError:
        raise MeshError(f"line {line}: expected an integer, got {quote(word)}") from None
    return max(-(2**63), min(value, 2**63 - 1))


def _has_underscore(word: bytes | str) -> bool:
    """Return whether a word has an underscore, which Python alone accepts between digits."""
    return b"_" in word if isinstance(word, bytes) else "_" in word


def write_points(file: BinaryIO, template: bytes, mesh: Mesh) -> None:
    """Write one line per point, with the shortest decimals that are read back as the same float64."""
    for start in range(0, mesh.n_points, _ROWS_PER_WRITE):
        rows = mesh.positions[start : start + _ROWS_PER_WRITE]
        file.write((template * len(rows)) % tuple(rows.ravel().tolist()))


def write_faces(
    file: BinaryIO, template: Callable[[int], bytes], mesh: Mesh, first: int, rows: range | None = None
) -> None:
    """Write one line per face.

    template : returns the line for a face of so many corners, with a placeholder for each index
    first : the index of the first point
    rows : the faces to write; all by default
    """
    rows = range(mesh.n_faces) if rows is None else rows
    sizes = np.diff(mesh.offsets[rows.start : rows.stop + 1])
    templates = {size: template(size) for size in np.unique(sizes).tolist()}
    for start in range(0, len(rows), _ROWS_PER_WRITE):
        some = sizes[start : start + _ROWS_PER_WRITE].tolist()
        begin = rows.start + start
        corners = mesh.indices[mesh.offsets[begin] : mesh.offsets[begin + len(some)]] + first
        file.write(b"".join(map(templates.__getitem__, some)) % tuple(corners.tolist()))
