"""The accessors of a glTF document: typed arrays in its buffers, which are not trusted to be there (3.6).

Section numbers are those of the glTF 2.0 specification.
"""

from collections.abc import Sequence
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from .._core.interrupts import defer_interrupts
from .._core.types import Float64Array
from .._core.widen import widen
from ..errors import MeshError, MissingExtraError
from ._text import quote
from .gltf_draco import DracoMesh
from .limits import budget

DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
N_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
MESHOPT = "EXT_meshopt_compression"
# An accessor without a buffer view is all zeros, and a compressed one may unpack to more than the file has.
_MAX_ZEROS = 1 << 25
_MAX_MESHOPT_RATIO = 100

Buffers = Sequence[bytes | memoryview]


class Accessors:
    """The accessors of a document as arrays; each raises MeshError if the document contradicts itself about it."""

    def __init__(self, document: Any, buffers: Buffers) -> None:
        self._accessors = document.get("accessors", [])
        self._views = document.get("bufferViews", [])
        self._buffers = buffers
        self._unpacked: dict[int, tuple[bytes, int]] = {}
        self._copies: dict[tuple[int, int, int], bytes] = {}
        self._n_copied = 0
        self.draco: dict[int, DracoMesh] = {}
        """The streams of Draco that were unpacked, by their buffer views: several primitives may name one."""
        self._replaced: dict[int, npt.NDArray[Any]] = {}
        self._rows: dict[int, npt.NDArray[Any]] = {}  # of accessors that primitives share: views, which take no memory
        self._floats = WeakValueDictionary[int, npt.NDArray[Any]]()  # that somebody holds
        self.n_bytes = sum(len(buffer) for buffer in {id(buffer): buffer for buffer in buffers}.values())

    def components(self, i: int, *types: str) -> npt.NDArray[Any]:
        """Return accessor i as it is stored, one row per element: (count, components). `types` are those allowed."""
        accessor, kind = self._accessors[i], self._require_type(i, types)
        if i in self._replaced:
            return self._replaced[i]
        if i in self._rows:
            return self._rows[i]
        count, dtype = get_count(accessor, "count"), np.dtype(DTYPES[accessor["componentType"]])
        if "bufferView" in accessor:
            rows = self._read(accessor, count, dtype, kind, f"accessor {i}")
            if "sparse" not in accessor:
                self._rows[i] = rows
        elif count * N_COMPONENTS[kind] > _MAX_ZEROS:
            raise MeshError(f"accessor {i} has {count} rows of zeros without a buffer view")
        else:
            rows = np.broadcast_to(np.zeros(1, dtype), (count, N_COMPONENTS[kind]))
        return self._overwritten(rows, accessor["sparse"], kind, f"accessor {i}") if "sparse" in accessor else rows

    def floats(self, i: int, *types: str) -> Float64Array:
        """Return accessor i as float64, read-only; integers that stand for fractions become those (3.6.2.2)."""
        self._require_type(i, types)
        values = self._floats.get(i)
        if values is None:
            values = self._as_floats(i, self.components(i))
            values.flags.writeable = False
            self._floats[i] = values
        return values

    def indices(self, i: int) -> npt.NDArray[np.uint32]:
        """Return accessor i as indices of points (c,)."""
        rows = self.components(i, "SCALAR")
        if rows.dtype.kind != "u":
            raise MeshError(f"accessor {i} holds indices, which must be unsigned integers, got {rows.dtype.name}")
        return rows[:, 0].astype(np.uint32)

    def matrices(self, i: int, n: int) -> Float64Array:
        """Return the first n of accessor i as matrices (n, 4, 4), which the file holds column by column."""
        return self._as_floats(i, self.components(i, "MAT4")[:n]).reshape(-1, 4, 4).transpose(0, 2, 1)

    def count(self, i: int) -> int:
        """Return the number of elements of accessor i."""
        return get_count(self._accessors[i], "count")

    def has_content(self, i: int) -> bool:
        """Tell whether accessor i has bytes of its own."""
        return "bufferView" in self._accessors[i]

    def replace(self, i: int, rows: npt.NDArray[Any]) -> None:
        """Let `rows` stand for accessor i from now on."""
        accessor = self._accessors[i]
        count, width = get_count(accessor, "count"), N_COMPONENTS[accessor["type"]]
        if rows.shape != (count, width):
            raise MeshError(f"accessor {i} declares {count} rows of {width}, its content has shape {rows.shape}")
        self._replaced[i] = rows
        self._floats.pop(i, None)

    def is_normalized(self, i: int) -> bool:
        """Tell whether the integers of accessor i stand for fractions."""
        return bool(self._accessors[i].get("normalized"))

    def view_bytes(self, v: int) -> memoryview:
        """Return the content of buffer view v, unpacked if it is compressed (3.6.1)."""
        return memoryview(self._view(v)[0])

    def _require_type(self, i: int, types: Sequence[str]) -> str:
        """Return the type of accessor i, which must be one of `types`, or any there is."""
        kind: str = self._accessors[i]["type"]
        if (types and kind not in types) or kind not in N_COMPONENTS:
            expected = " or ".join(types or N_COMPONENTS)
            raise MeshError(f"accessor {i} must be of type {expected}, got {quote(repr(kind))}")
        return kind

    def _as_floats(self, i: int, rows: npt.NDArray[Any]) -> Float64Array:
        """Return rows of accessor i as float64, a new array."""
        values = widen(rows)
        if self.is_normalized(i) and rows.dtype.kind in "iu":
            values /= np.iinfo(rows.dtype).max
            np.maximum(values, -1.0, out=values)
        return values

    def copy_view(self, v: int) -> bytes:
        """Return the content of buffer view v, one object for all views of one place.

        Raises MeshError if such places overlap, so that they have more bytes than the buffers.
        """
        data, _ = self._view(v)
        if isinstance(data, bytes):  # unpacked, once
            return data
        place = id(data.obj), get_count(self._views[v], "byteOffset", 0), len(data)
        if place not in self._copies:
            self._n_copied += len(data)
            if self._n_copied > self.n_bytes:
                raise MeshError(f"its images overlap: they have {self._n_copied} bytes, its buffers {self.n_bytes}")
            self._copies[place] = bytes(data)
        return self._copies[place]

    def _read(self, holder: Any, count: int, dtype: np.dtype[Any], kind: str, name: str) -> npt.NDArray[Any]:
        """Return `count` elements of the buffer view that `holder` names, from its byteOffset."""
        data, stride = self._view(get_count(holder, "bufferView"))
        n_columns = int(kind[3]) if kind.startswith("MAT") else 1
        n_rows = N_COMPONENTS[kind] // n_columns
        column_bytes = n_rows * dtype.itemsize
        if n_columns > 1:
            column_bytes += -column_bytes % 4  # columns of matrices are aligned (3.6.2.4)
        element_bytes = n_columns * column_bytes
        stride = stride or element_bytes
        if stride < element_bytes:
            raise MeshError(f"{name} has rows of {element_bytes} bytes every {stride} bytes")
        start = get_count(holder, "byteOffset", 0)
        end = start + (stride * (count - 1) + element_bytes if count else 0)
        if end > len(data):
            raise MeshError(f"{name} with {count} rows ends at byte {end} of a view of {len(data)}")
        if count < 2:
            stride = element_bytes  # of which there is none: it may be beyond any integer of NumPy
        shape, strides = (count, n_columns, n_rows), (stride, column_bytes, dtype.itemsize)
        return np.ndarray(shape, dtype, data, start, strides).reshape(count, N_COMPONENTS[kind])

    def _overwritten(self, rows: npt.NDArray[Any], sparse: Any, kind: str, name: str) -> npt.NDArray[Any]:
        """Return rows some of which a sparse accessor replaces (3.6.2.3)."""
        count = get_count(sparse, "count")
        if count > len(rows):
            raise MeshError(f"{name} replaces {count} of {len(rows)} rows")
        kept = sparse["indices"]
        places = self._read(kept, count, np.dtype(DTYPES[kept["componentType"]]), "SCALAR", f"{name}, sparse indices")
        at = places[:, 0].astype(np.int64)
        if len(at) and (at.min() < 0 or at.max() >= len(rows) or (np.diff(at) <= 0).any()):
            raise MeshError(f"{name}: its sparse indices must ascend within 0..{len(rows) - 1}")
        result = np.array(rows)
        result[at] = self._read(sparse["values"], count, rows.dtype, kind, f"{name}, sparse values")
        return result

    def _view(self, v: int) -> tuple[bytes | memoryview, int]:
        """Return the bytes of buffer view v, and its stride or 0."""
        view = self._views[v]
        packed = view.get("extensions", {}).get(MESHOPT)
        if packed is not None:
            if v not in self._unpacked:
                stride = get_count(packed, "byteStride")
                self._unpacked[v] = _unpack(packed, self._slice(packed, f"buffer view {v}, compressed,")), stride
            data, stride = self._unpacked[v]
            return data, stride if packed["mode"] == "ATTRIBUTES" else 0
        return self._slice(view, f"buffer view {v}"), get_count(view, "byteStride", 0)

    def _slice(self, view: Any, name: str) -> memoryview:
        buffer = self._buffers[get_count(view, "buffer")]
        start, n_bytes = get_count(view, "byteOffset", 0), get_count(view, "byteLength")
        if start + n_bytes > len(buffer):
            raise MeshError(f"{name} ends at byte {start + n_bytes}, the buffer has {len(buffer)}")
        return memoryview(buffer)[start : start + n_bytes]


def get_count(holder: Any, key: str, default: int | None = None) -> int:
    """Return a count, an offset or an index that `holder` has under `key`."""
    value = holder[key] if default is None else holder.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise MeshError(f"{key} must be an integer of at least 0, got {quote(repr(value))}")
    return value


def _unpack(packed: Any, data: memoryview) -> bytes:
    """Return what a buffer view of EXT_meshopt_compression stands for."""
    try:
        with defer_interrupts():
            import meshopt
    except ImportError:
        raise MissingExtraError(f"{MESHOPT} needs meshopt: pip install 'gpu_xform[gltf]'") from None
    count, stride = get_count(packed, "count"), get_count(packed, "byteStride")
    budget().take_bytes(count * stride, _MAX_MESHOPT_RATIO, MESHOPT)
    try:
        rows = meshopt.decode_gltf_buffer(bytes(data), count, stride, packed["mode"], packed.get("filter", "NONE"))
    except MemoryError:
        raise
    except Exception as error:  # whatever damaged content brings the library to
        raise MeshError(f"{MESHOPT}: {error}") from None
    return np.ascontiguousarray(rows).tobytes()
