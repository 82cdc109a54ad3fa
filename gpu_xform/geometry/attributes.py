"""Attributes: named arrays per point, per corner and per face of a mesh."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, Mapping
from functools import cache
from itertools import pairwise
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import require_room
from .._core.masked import require_whole
from .._core.public import public
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array, IndexArray
from .._core.widen import widen
from ..errors import MeshError

_KINDS = "biufcSU"  # numbers, truth values and texts
_TINY, _HUGE = 2.0**-500, 2.0**500  # lengths between them have squares of all digits


@public
class RaggedArray:
    """An immutable array whose rows differ in length, such as a list property of a PLY file.

    `len`, `[i]` and iteration give one array per row.

    Parameters
    ----------
    values : (v,) numbers
        All rows, one after another; copied.
    offsets : (n + 1,) integers
        Where each row starts in `values`, from 0 to v; copied.

    Raises
    ------
    MeshError
        If the offsets do not split the values.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, values: npt.ArrayLike, offsets: npt.ArrayLike) -> None:
        self._values = _as_read_only(values, "values")
        self._offsets = _as_read_only(np.asarray(offsets).astype(np.int64, casting="same_kind"), "offsets")
        if self._values.ndim != 1 or self._offsets.ndim != 1:
            raise MeshError("values and offsets of a ragged array must have one dimension")
        ends = self._offsets[[0, -1]].tolist() if len(self._offsets) else []
        if ends != [0, len(self._values)] or (np.diff(self._offsets) < 0).any():
            raise MeshError(f"offsets must ascend from 0 to {len(self._values)}, the number of values, got {ends}")

    @property
    def values(self) -> npt.NDArray[Any]:
        """All rows, one after another: (v,), read-only."""
        return self._values

    @property
    def offsets(self) -> IndexArray:
        """Where each row starts in `values`: (n + 1,) int64, read-only."""
        return self._offsets

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of the values."""
        return self._values.dtype

    def __len__(self) -> int:
        return len(self._offsets) - 1

    def __getitem__(self, row: int) -> npt.NDArray[Any]:
        row = range(len(self))[row]
        values: npt.NDArray[Any] = self._values[self._offsets[row] : self._offsets[row + 1]]
        return values

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        return (self._values[start:end] for start, end in pairwise(self._offsets.tolist()))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RaggedArray):
            return NotImplemented
        return _are_equal(self._values, other._values) and _are_equal(self._offsets, other._offsets)

    def __reduce__(self) -> tuple[Any, ...]:
        return RaggedArray, (self._values, self._offsets)

    def __repr__(self) -> str:
        return f"<RaggedArray: {len(self)} rows of {self.dtype}>"


Column: TypeAlias = npt.NDArray[Any] | RaggedArray
ColumnLike: TypeAlias = npt.ArrayLike | RaggedArray
Columns: TypeAlias = Mapping[str, Any]  # to `Column`s; Any, for most callers know which of the two they have
ColumnsLike: TypeAlias = Mapping[str, ColumnLike]


@public
class Attributes:
    """What a mesh holds beside points and faces: named arrays with one row per point, per corner or per face.

    Any name and any type of numbers or texts will do. Two names have a meaning of their own: `Mesh.transformed` moves
    a "normal" by the inverse transpose of the matrix, and a "tangent" as a vector. Readers and writers of files agree
    on "normal" (3,), "tangent" (3,) or (4,), "texcoord" (2,) or (3,), and "color" (3,) or (4,), which is uint8 or
    floats in 0..1; docs/attributes.md lists what each format holds.

    Parameters
    ----------
    point, corner, face : mappings from a name to an array-like or a RaggedArray
        One row per point, one per corner in the order of `Mesh.indices`, and one per face; copied.
    labels : mapping from a name to a sequence of texts
        What the integers of the attribute of that name stand for: 0 is the first text, -1 stands for none.
    material : mapping from a name to a value
        What a file says of materials and textures, as it came.

    Raises
    ------
    MeshError
        For a value that is no array of numbers, truth values or texts, or a name that is no text.
    """

    __hash__ = None  # type: ignore[assignment]
    __slots__ = ("_corner", "_face", "_labels", "_material", "_point")

    def __init__(
        self,
        point: ColumnsLike | None = None,
        corner: ColumnsLike | None = None,
        face: ColumnsLike | None = None,
        *,
        labels: Mapping[str, Any] | None = None,
        material: Mapping[str, Any] | None = None,
    ) -> None:
        self._point = _as_columns(point, "point")
        self._corner = _as_columns(corner, "corner")
        self._face = _as_columns(face, "face")
        self._labels = MappingProxyType({name: _as_texts(texts, name) for name, texts in (labels or {}).items()})
        self._material: Mapping[str, Any] = freeze_value(dict(material or {}))

    @property
    def point(self) -> Columns:
        """The attributes with one row per point, by name; read-only."""
        return self._point

    @property
    def corner(self) -> Columns:
        """The attributes with one row per corner, in the order of `Mesh.indices`, by name; read-only."""
        return self._corner

    @property
    def face(self) -> Columns:
        """The attributes with one row per face, by name; read-only."""
        return self._face

    @property
    def labels(self) -> Mapping[str, tuple[str, ...]]:
        """The texts that the integers of an attribute stand for, by the attribute's name; read-only."""
        return self._labels

    @property
    def material(self) -> Mapping[str, Any]:
        """What the file says of materials and textures, as it came; read-only."""
        return self._material

    def updated(self, other: Attributes) -> Attributes:
        """Return these attributes and those of `other`, which take the place of those of their names."""
        point, corner, face = ({**own, **new} for own, new in zip(self._tables(), other._tables(), strict=True))
        labels, material = {**self._labels, **other._labels}, {**self._material, **other._material}
        return Attributes(point, corner, face, labels=labels, material=material)

    def __bool__(self) -> bool:
        return any((self._point, self._corner, self._face, self._labels, self._material))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Attributes):
            return NotImplemented
        return (
            self._labels == other._labels
            and self._material == other._material
            and all(
                own.keys() == others.keys() and all(_are_equal(column, others[name]) for name, column in own.items())
                for own, others in zip(self._tables(), other._tables(), strict=True)
            )
        )

    def __reduce__(self) -> tuple[Any, ...]:
        tables = tuple(dict(table) for table in self._tables())
        return Attributes._restore, (*tables, dict(self._labels), thaw_value(self._material))

    @classmethod
    def _restore(cls, point: Any, corner: Any, face: Any, labels: Any, material: Any) -> Attributes:
        """Return the attributes that a pickle holds."""
        return cls(point, corner, face, labels=labels, material=material)

    def __repr__(self) -> str:
        return f"<Attributes: {self.summarize() or 'none'}>"

    def summarize(self) -> str:
        """Return the names in one line, such as "point: normal, color; face: material"."""
        tables = zip(("point", "corner", "face"), self._tables(), strict=True)
        parts = [f"{what}: {', '.join(table)}" for what, table in tables if table]
        return "; ".join(parts + (["material"] if self._material else []))

    def _tables(self) -> tuple[Columns, Columns, Columns]:
        return self._point, self._corner, self._face


AttributesLike: TypeAlias = Attributes | Mapping[str, Any]


def as_attributes(value: AttributesLike | None) -> Attributes:
    """Return `Attributes`; a mapping has its parameters as keys, such as {"point": {"normal": ...}}."""
    if value is None:
        return NO_ATTRIBUTES
    if isinstance(value, Attributes):
        return value
    if not isinstance(value, Mapping):
        raise MeshError(f"attributes must be Attributes or a mapping, got {type(value).__name__}")
    known = ("point", "corner", "face", "labels", "material")
    for name in value:
        if name not in known:
            raise MeshError(f"attributes must be among {', '.join(known)}, got {name!r}")
    return Attributes(**value)


def require_rows(attributes: Attributes, n_points: int, n_corners: int, n_faces: int) -> None:
    """Raise MeshError unless each attribute has a row per point, corner or face."""
    counts = {"point": n_points, "corner": n_corners, "face": n_faces}
    for (what, count), table in zip(counts.items(), attributes._tables(), strict=True):
        for name, column in table.items():
            if len(column) != count:
                raise MeshError(f"attribute {name!r} per {what} must have {count} rows, got {len(column)}")


def reorder_corners(attributes: Attributes, order: IndexArray) -> Attributes:
    """Return the attributes where row i per corner is row `order[i]` of before."""
    if not attributes.corner:
        return attributes
    return _replace(attributes, corner={name: take_rows(column, order) for name, column in attributes.corner.items()})


def transform_attributes(attributes: Attributes, linear: Float64Array) -> Attributes:
    """Return the attributes where points move by the 3x3 matrix `linear`: normals and tangents move, nothing else."""
    moving = [{"normal", "tangent"} & table.keys() for table in attributes._tables()]
    if not any(moving) or np.array_equal(linear, np.eye(3)):
        return attributes
    changed = [
        {**table, **{name: move_column(name, table[name], linear) for name in names}}
        for table, names in zip(attributes._tables(), moving, strict=True)
    ]
    return Attributes(*changed, labels=attributes.labels, material=attributes.material)


def move_column(name: str, column: Column, linear: Float64Array) -> Any:
    """Return a column of normals or tangents, moved, in its own type; a column of another shape stays.

    By matrices (..., 3, 3), columns (..., n, c).
    """
    if isinstance(column, RaggedArray) or column.ndim != 2 or column.dtype.kind not in "iuf":
        return column
    if name == "normal" and column.shape[1] == 3:
        moved = transform_normals(widen(column), linear)
    elif name == "tangent" and column.shape[1] in (3, 4):
        moved = np.empty((*linear.shape[:-2], *column.shape))
        moved[...] = tangents = widen(column)
        with np.errstate(over="ignore", invalid="ignore"):  # of components that are not finite, or huge
            moved[..., :3] = tangents[:, :3] @ np.swapaxes(linear, -1, -2)
        moved[..., 3:] *= _signs_of_determinants(linear)  # the bitangent's side, which mirrors swap
    else:
        return column
    return store_as(column.dtype, moved)


def store_as(dtype: np.dtype[Any], moved: Float64Array) -> npt.NDArray[Any]:
    """Return moved numbers in a type: of integers the nearest, within their range."""
    if dtype.kind in "iu":
        limits = np.iinfo(dtype)
        # The largest of 64 bits are no float64, which would round them up.
        largest = np.nextafter(float(limits.max), 0.0) if dtype.itemsize == 8 else limits.max
        moved = np.clip(np.rint(moved), limits.min, largest)
    with np.errstate(over="ignore"):
        return moved.astype(dtype)


def transform_normals(normals: Float64Array, linear: Float64Array) -> Float64Array:
    """Return normals (n, 3) moved by the inverse transpose of `linear`, as long as they were.

    By matrices (..., 3, 3), normals (..., n, 3).

    The matrix of cofactors, which is the determinant times the inverse transpose, gives the direction; it is there for
    singular matrices as well. A normal that it makes zero becomes zero.
    """
    largest = np.abs(linear).max(axis=(-2, -1), keepdims=True)
    scaled = linear / np.where(largest == 0.0, 1.0, largest)
    (a, b, c), (d, e, f), (g, h, i) = scaled.tolist() if linear.ndim == 2 else np.moveaxis(scaled, 0, -1)
    cofactors = np.array(  # by hand, for `np.cross` takes as long as a hundred normals
        [
            [e * i - f * h, f * g - d * i, d * h - e * g],
            [h * c - i * b, i * a - g * c, g * b - h * a],
            [b * f - c * e, c * d - a * f, a * e - b * d],
        ]
    )
    transposed = cofactors.T if linear.ndim == 2 else np.moveaxis(cofactors, -1, 0).swapaxes(-1, -2)
    turn = _signs_of_determinants(linear) * transposed
    exponents: npt.NDArray[Any] | None = None
    with np.errstate(over="ignore", invalid="ignore"):  # of what a file says: components that are not finite, or huge
        moved: Float64Array = normals @ turn
        lengths, lengths_before = np.linalg.norm(moved, axis=-1), np.linalg.norm(normals, axis=1)
        if not (_have_squares(lengths) and _have_squares(lengths_before)):
            normals, exponents = _split_exponents(normals)
            moved, _ = _split_exponents(normals @ turn)
            lengths, lengths_before = np.linalg.norm(moved, axis=-1), np.linalg.norm(normals, axis=1)
        lengths[lengths == 0] = 1.0
        moved *= (lengths_before / lengths)[..., np.newaxis]
        return moved if exponents is None else np.ldexp(moved, exponents)


def _have_squares(lengths: Float64Array) -> bool:
    """Tell whether the squares of all lengths, which they were made of, are numbers of all digits."""
    return bool(((lengths > _TINY) & (lengths < _HUGE)).all())


def _split_exponents(vectors: Float64Array) -> tuple[Float64Array, npt.NDArray[Any]]:
    """Return vectors (..., n, 3) with a largest component of 0.5 to 1, unless it is not finite, and powers of two.

    The vectors times two to these powers, (..., n, 1), are those given.
    """
    largest = np.abs(vectors).max(axis=-1, keepdims=True)
    exponents = np.frexp(np.where(np.isfinite(largest), largest, 0.0))[1]
    return np.ldexp(vectors, -exponents), exponents


def _signs_of_determinants(linear: Float64Array) -> Any:
    """Return those of matrices (..., 3, 3), as something to multiply (..., n, c) by."""
    if linear.ndim == 2:
        return sign_of_determinant(linear)
    with np.errstate(divide="ignore"):
        return np.where(np.linalg.slogdet(linear)[0] < 0.0, -1.0, 1.0)[..., np.newaxis, np.newaxis]


def sign_of_determinant(matrix: Float64Array) -> float:
    """Return -1 for a matrix that mirrors, else 1; the determinant itself could underflow."""
    if matrix.shape == (3, 3):
        (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
        largest = max(abs(a), abs(b), abs(c), abs(d), abs(e), abs(f), abs(g), abs(h), abs(i))
        if 1e-90 < largest < 1e90:
            determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
            if abs(determinant) > 1e-12 * largest**3:  # far more than it is rounded by
                return -1.0 if determinant < 0.0 else 1.0
    return -1.0 if bool(are_mirroring(matrix)) else 1.0


def are_mirroring(matrices: Float64Array) -> npt.NDArray[np.bool_]:
    """Return whether each of (..., s, s) matrices mirrors, s <= 4."""
    is_large = np.abs(matrices).max(axis=(-2, -1), keepdims=True) > 1e300  # elimination may multiply it by 8
    with np.errstate(divide="ignore", invalid="ignore"):  # the logarithm of 0, and matrices that are not finite
        signs = np.linalg.slogdet(np.where(is_large, matrices / 16.0, matrices))[0]
    return np.asarray(signs < 0.0)


class FrozenDict(Mapping[Any, Any]):
    """A mapping of `freeze_value`, which need not be frozen again."""

    __hash__ = None  # type: ignore[assignment]
    __slots__ = ("_items",)

    def __init__(self, items: dict[Any, Any]) -> None:
        self._items = items

    def __getitem__(self, key: Any) -> Any:
        return self._items[key]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def items(self) -> ItemsView[Any, Any]:
        """Return the items: those of the dictionary within, as `Mapping` takes its time."""
        return self._items.items()

    def __eq__(self, other: object) -> bool:
        return self is other or self._items == other

    def __repr__(self) -> str:
        return repr(self._items)


class FrozenTuple(tuple[Any, ...]):
    """A tuple of `freeze_value`, which need not be frozen again."""

    __slots__ = ()


def freeze_value(value: Any) -> Any:
    """Return plain data that cannot be written to: mappings, tuples for lists, and read-only arrays, at any depth.

    What it has returned once it returns as it is: many meshes may share it.
    """
    if isinstance(value, FrozenDict | FrozenTuple):
        return value
    if isinstance(value, Mapping):
        return FrozenDict({key: freeze_value(item) for key, item in value.items()})
    if isinstance(value, list | tuple):
        return FrozenTuple(map(freeze_value, value)) if value else ()
    return _as_read_only(value, "value") if isinstance(value, np.ndarray) else value


def thaw_value(value: Any) -> Any:
    """Return plain data with dicts for the read-only mappings of `freeze_value`, as pickles need."""
    if isinstance(value, Mapping):
        return {key: thaw_value(item) for key, item in value.items()}
    return tuple(map(thaw_value, value)) if isinstance(value, tuple) else value


def _replace(attributes: Attributes, **tables: ColumnsLike) -> Attributes:
    """Return the attributes with other tables."""
    kept = dict(zip(("point", "corner", "face"), attributes._tables(), strict=True))
    return Attributes(**{**kept, **tables}, labels=attributes.labels, material=attributes.material)


def take_rows(column: Column, rows: IndexArray) -> Column:
    """Return the chosen rows of a column."""
    if not isinstance(column, RaggedArray):
        taken: npt.NDArray[Any] = column[rows]
        return taken
    sizes = np.diff(column.offsets)[rows]
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)])
    places = np.repeat(column.offsets[:-1][rows] - offsets[:-1], sizes) + np.arange(offsets[-1])
    return RaggedArray(column.values[places], offsets)


class _Table(dict[str, Column]):
    """Columns by name; a name that is not there is told with those that are."""

    def __init__(self, what: str) -> None:
        super().__init__()
        self._what = what

    def __missing__(self, name: str) -> Column:
        known = ", ".join(self) or "none"
        hint = did_you_mean(str(name), self).replace("'", "")
        raise KeyError(f"no attribute {name} per {self._what}, there are: {known}{hint}")


@cache
def _no_columns(what: str) -> Columns:
    return MappingProxyType(_Table(what))


def _as_columns(table: ColumnsLike | None, what: str) -> Columns:
    """Return a read-only mapping of read-only columns; one without columns is shared, as most meshes have two."""
    if not table:
        return _no_columns(what)
    columns = _Table(what)
    for name, value in table.items():
        if not name or not isinstance(name, str):
            raise MeshError(f"the name of an attribute per {what} must be a text, got {name!r}")
        columns[name] = value if isinstance(value, RaggedArray) else _as_read_only(value, f"attribute {name!r}")
        if not isinstance(value, RaggedArray) and np.ndim(value) == 0:
            raise MeshError(f"attribute {name!r} per {what} must have one row per {what}, got one value")
    return MappingProxyType(columns)


def _as_texts(texts: Any, name: str) -> tuple[str, ...]:
    """Return what the integers of an attribute stand for."""
    if hasattr(texts, "__array__"):
        require_whole(texts, f"labels of {name!r}")
        texts = np.asarray(texts)
        require_room(texts, f"labels of {name!r}")
    return tuple(map(str, texts))


def _as_read_only(value: npt.ArrayLike, name: str) -> npt.NDArray[Any]:
    """Return `value` as an array that nobody can write to, in the machine's byte order; copied unless it is one."""
    if not isinstance(value, np.ndarray):  # of one that has a mask, all numbers are kept
        require_whole(value, name)
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise MeshError(f"{name} must be a rectangular array, or a RaggedArray: {error}") from None
    require_room(array, name)
    if array.dtype.kind not in _KINDS:
        raise MeshError(f"{name} must hold numbers, truth values or texts, got dtype {array.dtype}")
    if not array.flags.c_contiguous or not array.dtype.isnative or not _is_closed(array):
        array = np.array(array, array.dtype.newbyteorder("="), order="C")
        array.flags.writeable = False
    return array


def _is_closed(array: npt.NDArray[Any]) -> bool:
    """Tell whether neither an array nor the memory that it looks at can be written to."""
    base: Any = array
    while isinstance(base, np.ndarray):
        if base.flags.writeable:
            return False
        base = base.base
    return base is None or isinstance(base, bytes)


def _are_equal(a: Column, b: Column) -> bool:
    """Tell whether two columns have the same type, shape and values, NaN included."""
    if isinstance(a, RaggedArray) or isinstance(b, RaggedArray):
        return a is b or (isinstance(a, RaggedArray) and a == b)
    return a is b or (a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc"))


NO_ATTRIBUTES = Attributes()
