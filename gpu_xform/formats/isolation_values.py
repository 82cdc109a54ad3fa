"""Values that leave isolation: JSON, and arrays in memory that two processes share.

What is decoded is not trusted: there are no pickles, and every array is checked against the memory.
"""

import errno
import json
import math
import mmap
import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import MeshError
from ..geometry.attributes import FrozenDict, FrozenTuple, RaggedArray, freeze_value

_N_STANDARD_STREAMS = 3
_FEW_BYTES = 1 << 16  # smaller arrays wait for others, as each write takes its time
_KINDS = "biuf"
_PLAIN = frozenset({bool, float, int, str, type(None)})
_MAX_COPIED = 32  # values of frozen data: so few are sent with each part that has them, in half of the time


def create_memory() -> int:
    """Return a descriptor of memory to share; never one of the standard streams, which may be closed in a service."""
    import fcntl

    memory = os.memfd_create("gpu_xform")
    try:
        return fcntl.fcntl(memory, fcntl.F_DUPFD_CLOEXEC, _N_STANDARD_STREAMS)
    finally:
        os.close(memory)


def encode(value: Any, memory: int, memory_bytes: int) -> Any:
    """Return a value as JSON holds it, with its arrays in the shared memory.

    Raises MeshError for what cannot be carried, and where the arrays take more than the limit of the size of files;
    MemoryError where they take more than `memory_bytes`.
    """
    arrays = _SharedArrays(memory, memory_bytes)
    encoded = _encode(value, arrays.append, {})
    arrays.flush()
    return encoded


def decode(value: Any, memory: int) -> Any:
    """Return what `encode` was given, with arrays of our own; an error of any kind for anything else."""
    n_bytes = os.fstat(memory).st_size
    shared = mmap.mmap(memory, n_bytes, access=mmap.ACCESS_READ) if n_bytes else b""
    return _decode(value, shared, [])


def _encode(value: Any, append: Callable[[npt.NDArray[Any]], int], known: dict[int, tuple[Any, int]]) -> Any:
    """Return a value as JSON holds it; `append` puts an array into the shared memory, and returns where.

    known : what was encoded, and its number, by its identity: what several parts of the model share is there once
    """
    if type(value) in _PLAIN:  # first, as most are, and to ask for an abstract type is slow
        return value
    if type(value) is list:
        is_plain = _PLAIN.issuperset(map(type, value))
        return value if is_plain else [_encode(each, append, known) for each in value]
    if not isinstance(value, FrozenDict | tuple | np.ndarray | bytes | bytearray | memoryview):
        return _encode_once(value, append, known)
    if id(value) in known:
        return {"again": known[id(value)][1]}
    if isinstance(value, FrozenDict | FrozenTuple):
        is_json = _count_json(value, _MAX_COPIED) <= _MAX_COPIED
        made = {"json": value} if is_json else {"frozen": _encode_once(value, append, known)}
    else:
        made = _encode_once(value, append, known)
    known[id(value)] = value, len(known)
    return made


def _count_json(value: Any, most: int) -> int:
    """Return how many values frozen data hold; more than `most` if they are more, or JSON does not hold them as is.

    Keys count as values do, and each eight characters of a text.
    """
    if type(value) is str:
        return 1 + len(value) // 8
    if type(value) in _PLAIN:
        return 1
    if not isinstance(value, FrozenDict | tuple) or len(value) > most:  # before it is gone through
        return most + 1
    if isinstance(value, tuple):
        parts = list(value)
    elif all(type(key) is str for key in value):
        parts = [part for item in value.items() for part in item]
    else:
        return most + 1
    count = 1
    for part in parts:
        count += _count_json(part, most - count)
        if count > most:
            break
    return count


def dump(value: Any) -> bytes:
    """Return the text, in UTF-8, of what `encode` returned, or of what it is within.

    Nothing is escaped: of two halves of a surrogate pair, which a file may hold as two characters, it would make one.
    """
    return json.dumps(value, default=_thaw, ensure_ascii=False).encode("utf-8", "surrogatepass")


def _thaw(value: FrozenDict) -> dict[Any, Any]:
    return dict(value.items())


def _encode_once(value: Any, append: Callable[[npt.NDArray[Any]], int], known: dict[int, tuple[Any, int]]) -> Any:
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in _KINDS:
            raise MeshError(f"an attribute of dtype {value.dtype} cannot be carried out of isolation")
        array = np.asarray(value, order="C")
        return {"array": [append(array), list(array.shape), array.dtype.str]}
    if isinstance(value, RaggedArray):
        return {"ragged": [_encode(value.values, append, known), _encode(value.offsets, append, known)]}
    if isinstance(value, bytes | bytearray | memoryview):
        return {"bytes": _encode_once(np.frombuffer(value, np.uint8), append, known)}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {"map": [[_encode(key, append, known), _encode(each, append, known)] for key, each in value.items()]}
    if isinstance(value, tuple):
        return {"tuple": [_encode(each, append, known) for each in value]}
    if isinstance(value, bool | int | float | str):
        return value
    raise MeshError(f"{type(value).__name__} cannot be carried out of isolation")


def _decode(value: Any, shared: Any, known: list[Any]) -> Any:
    """Return what `_encode` was given, with arrays copied out of the shared memory, each once, and read-only.

    known : what was decoded and cannot change, by its number
    """
    if isinstance(value, list):
        is_plain = _PLAIN.issuperset(map(type, value))
        return value if is_plain else [_decode(each, shared, known) for each in value]
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    match kind:
        case "again":
            return known[content]
        case "json":
            made = freeze_value(content)
        case "frozen":
            ((kind, content),) = content.items()
            made = freeze_value(_decode_once(kind, content, shared, known))
        case _:
            made = _decode_once(kind, content, shared, known)
    if isinstance(made, FrozenDict | tuple | np.ndarray | bytes):
        known.append(made)
    return made


def _decode_once(kind: str, content: Any, shared: Any, known: list[Any]) -> Any:
    match kind:
        case "array":
            start, shape, text = content
            dtype = np.dtype(str(text))
            if dtype.kind not in _KINDS or not all(type(side) is int and side >= 0 for side in [start, *shape]):
                raise ValueError("an array is malformed")
            if start + math.prod(shape) * dtype.itemsize > len(shared):
                raise ValueError("an array is outside of the shared memory")
            array = np.ndarray(shape, dtype, shared, start).copy()
            array.flags.writeable = False
            return array
        case "ragged":
            return RaggedArray(*(_decode(each, shared, known) for each in content))
        case "bytes":
            ((kind, content),) = content.items()
            return _decode_once(kind, content, shared, known).tobytes()
        case "map":
            return {_decode(key, shared, known): _decode(each, shared, known) for key, each in content}
        case "tuple":
            return tuple(_decode(each, shared, known) for each in content)
    raise ValueError(f"unknown content {kind!r}")


class _SharedArrays:
    """Arrays in memory that is shared, one after the other; small ones are written many at a time."""

    def __init__(self, memory: int, memory_bytes: int) -> None:
        self._memory, self._memory_bytes = memory, memory_bytes
        self._end = 0
        self._waiting = bytearray()

    def append(self, array: npt.NDArray[Any]) -> int:
        """Return where the array is when all is written."""
        start = self._end
        self._end += array.nbytes
        if array.nbytes >= _FEW_BYTES:
            self.flush()
            self._write(array.reshape(-1).view(np.uint8).data)
            return start
        self._waiting += array.tobytes()
        if len(self._waiting) >= _FEW_BYTES:
            self.flush()
        return start

    def flush(self) -> None:
        """Write what waits for more."""
        self._write(memoryview(self._waiting))
        self._waiting = bytearray()

    def _write(self, rest: memoryview) -> None:
        import resource  # of Linux alone

        try:
            while rest:
                rest = rest[os.write(self._memory, rest) :]
        except OSError as error:
            if error.errno not in (errno.EFBIG, errno.ENOSPC):
                raise
            most_bytes = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
            if error.errno == errno.EFBIG and 0 <= most_bytes < self._memory_bytes:
                told = f"its arrays take more than {most_bytes:,} bytes, the limit of the size of files (ulimit -f)"
                raise MeshError(told) from None
            raise MemoryError from None  # the limit of the size of files is that of memory
