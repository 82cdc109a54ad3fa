"""Polygon meshes: positions, and faces of any size in flat arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import chain
from types import MappingProxyType
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, describe_first_non_finite, require_affine
from .._core.masked import drop_hidden_rows, require_unmasked
from .._core.pictured import Pictured
from .._core.public import public
from .._core.types import Float64Array, IndexArray, MatrixLike
from ..errors import ArgumentError, MeshError
from .attributes import (
    NO_ATTRIBUTES,
    Attributes,
    AttributesLike,
    as_attributes,
    freeze_value,
    reorder_corners,
    require_rows,
    sign_of_determinant,
    thaw_value,
    transform_attributes,
)
from .triangulation import triangulate

FacesLike: TypeAlias = npt.ArrayLike | Sequence[npt.ArrayLike]
Flip: TypeAlias = Literal["auto"] | bool

_Array = TypeVar("_Array", bound=npt.NDArray[Any])
_NO_METADATA: Mapping[str, Any] = MappingProxyType({})
_MAX_POINTS = 2**32 - 1  # `pack_pairs` puts two indices into one uint64


@public
class Mesh(Pictured):
    """An immutable mesh: points, and faces that are polygons of three or more corners or segments of two.

    Every array that a mesh returns is read-only.

    Parameters
    ----------
    positions : (n, 3) numbers
        The points; copied, and finite. Without faces, rows that a mask hides are left out.
    faces : (f, k) integers, or a sequence of sequences of two or more integers
        The corners of each face, as indices of points; copied. Without faces, the mesh is a point cloud.
    attributes : Attributes, or a mapping such as {"point": {"color": colors}}
        Named arrays with one row per point, per corner or per face.
    metadata : mapping
        What else a file says: comments, the types of its numbers. Two meshes are equal whatever it holds.

    Raises
    ------
    MeshError
        For a wrong shape, a coordinate that is not finite, an index that is not an integer in 0..n-1, such as
        "face 1 names point 4, outside 0..3 (4 points)", or an attribute with another number of rows.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self,
        positions: npt.ArrayLike,
        faces: FacesLike = (),
        *,
        attributes: AttributesLike | None = None,
        metadata: Mapping[str, Any] | None = None,
    ) -> None:
        offsets, indices = _flatten_faces(faces)
        shown = drop_hidden_rows(positions) if len(indices) == 0 else positions
        self._set(_validate_positions(shown), offsets, indices)
        self._set_attributes(attributes, metadata)

    @classmethod
    def from_offsets(
        cls,
        positions: npt.ArrayLike,
        offsets: npt.ArrayLike,
        indices: npt.ArrayLike,
        *,
        attributes: AttributesLike | None = None,
        metadata: Mapping[str, Any] | None = None,
    ) -> Mesh:
        """Return the mesh whose face i has the corners `indices[offsets[i]:offsets[i + 1]]`.

        Parameters
        ----------
        positions : (n, 3) numbers
            The points; copied, and finite.
        offsets : (f + 1,) integers
            Where each face starts in `indices`, from 0 to len(indices); copied.
        indices : (c,) integers
            The corners of all faces, one face after another; copied.
        attributes, metadata
            As `Mesh` takes them.

        Returns
        -------
        Mesh

        Raises
        ------
        MeshError
            As `Mesh` does, and if the offsets do not fit the indices.
        """
        mesh = cls.__new__(cls)
        mesh._set(
            _validate_positions(positions),
            np.array(_as_integers(offsets, "offsets", 1)),
            np.array(_as_integers(indices, "indices", 1)),
        )
        mesh._set_attributes(attributes, metadata)
        return mesh

    @classmethod
    def from_trimesh(cls, mesh: Any) -> Mesh:
        """Return a mesh of the vertices and triangles of a `trimesh.Trimesh`, with its colours as attributes "color".

        Parameters
        ----------
        mesh : trimesh.Trimesh
            Its arrays are copied.

        Returns
        -------
        Mesh
        """
        kind = {"vertex": "point", "face": "face"}.get(getattr(mesh.visual, "kind", None) or "")
        colors = {} if kind is None else {kind: {"color": getattr(mesh.visual, f"{mesh.visual.kind}_colors")}}
        return cls(mesh.vertices, np.asarray(mesh.faces), attributes=colors)

    def _set(self, positions: Float64Array, offsets: IndexArray, indices: IndexArray) -> None:
        """Validate the indices, and take over the three arrays as read-only ones."""
        _require_offsets(offsets, len(indices))
        _require_indices(indices, offsets, len(positions))
        self._positions = _freeze(positions)
        self._offsets = _freeze(offsets)
        self._indices = _freeze(indices)

    def _set_attributes(self, attributes: AttributesLike | None, metadata: Mapping[str, Any] | None) -> None:
        """Validate the attributes, and take them and the metadata over as read-only ones."""
        self._attributes = as_attributes(attributes)
        if self._attributes:
            require_rows(self._attributes, self.n_points, len(self._indices), self.n_faces)
        self._metadata = freeze_value(metadata) if metadata else _NO_METADATA

    @property
    def positions(self) -> Float64Array:
        """The points: (n, 3) float64."""
        return self._positions

    @property
    def offsets(self) -> IndexArray:
        """Where each face starts in `indices`: (f + 1,) int64."""
        return self._offsets

    @property
    def indices(self) -> IndexArray:
        """The corners of all faces, one face after the other: (c,) int64."""
        return self._indices

    @property
    def attributes(self) -> Attributes:
        """The named arrays per point, per corner and per face, such as `attributes.point["normal"]`."""
        return self._attributes

    @property
    def metadata(self) -> Mapping[str, Any]:
        """What else the file says, by the name of its format, so that it can be written as it was; read-only."""
        return self._metadata

    @property
    def n_points(self) -> int:
        """The number of points."""
        return len(self._positions)

    @property
    def n_faces(self) -> int:
        """The number of faces, segments included."""
        return len(self._offsets) - 1

    @cached_property
    def faces(self) -> IndexArray | tuple[IndexArray, ...]:
        """The faces: (f, k) int64 if all have k corners, else a tuple of (k_i,) int64; () if there are none.

        Either way, `len`, `[i]` and iteration give one array per face, and `Mesh(positions, mesh.faces)` accepts it.
        """
        sizes = np.diff(self._offsets)
        if len(sizes) == 0:
            return ()
        if (sizes == sizes[0]).all():
            return self._indices.reshape(-1, int(sizes[0]))
        return tuple(np.split(self._indices, self._offsets[1:-1]))

    @cached_property
    def _half_edges(self) -> tuple[IndexArray, IndexArray]:
        """The directed edges of all faces (h, 2), and the face of each (h,)."""
        starts, ends = self._offsets[:-1], self._offsets[1:]
        next_corners = np.roll(self._indices, -1)
        next_corners[ends - 1] = self._indices[starts]
        edges = np.stack([self._indices, next_corners], axis=1)
        sizes = np.diff(self._offsets)
        owners = np.repeat(np.arange(self.n_faces), sizes)
        reverse = ends[sizes == 2] - 1  # a segment has one edge, not two
        if len(reverse):
            edges, owners = np.delete(edges, reverse, axis=0), np.delete(owners, reverse)
        return _freeze(edges), _freeze(owners)

    @property
    def face_edges(self) -> IndexArray:
        """The directed edges of every face, in the order of the faces: (h, 2) int64.

        A polygon of k corners gives its k edges (c0, c1), (c1, c2), ..., (ck-1, c0); a segment gives (c0, c1) alone.
        An edge that two faces share appears once for each; `face_edge_faces` holds the face of each row.
        """
        return self._half_edges[0]

    @property
    def face_edge_faces(self) -> IndexArray:
        """The face of each row of `face_edges`: (h,) int64, ascending."""
        return self._half_edges[1]

    @cached_property
    def last_face_edges(self) -> IndexArray:
        """The last row of `face_edges` for each edge, in either direction: (m,) int64, ascending."""
        _, from_last = np.unique(pack_pairs(*self.face_edges[::-1].T), return_index=True)
        return _freeze(np.sort(len(self.face_edges) - 1 - from_last))

    @cached_property
    def edges(self) -> IndexArray:
        """The edges of all faces, each once: (m, 2) int64, lower index first, sorted.

        An edge from a point to itself, as a corner repeated in succession makes it, is left out.
        """
        start, end = self.face_edges.T
        keys = pack_pairs(start, end)[start != end]
        keys.sort()
        keys = keys[np.diff(keys, prepend=keys[:1] - np.uint64(1)) != 0]
        return _freeze(unpack_pairs(keys))

    @cached_property
    def bounds(self) -> Float64Array:
        """The smallest and the largest coordinates over all points: (2, 3) float64.

        Raises
        ------
        MeshError
            "a mesh without points has no bounds".
        """
        if self.n_points == 0:
            raise MeshError("a mesh without points has no bounds")
        corners: Float64Array = np.stack([self._positions.min(axis=0), self._positions.max(axis=0)])
        return _freeze(corners)

    @cached_property
    def used_positions(self) -> Float64Array:
        """The points that faces use, in their order, or all points of a mesh without faces: (k, 3) float64."""
        if self.n_faces == 0:
            return self._positions
        is_used = np.zeros(self.n_points, np.bool_)
        is_used[self._indices] = True
        return self._positions if is_used.all() else _freeze(self._positions[is_used])

    @cached_property
    def center(self) -> Float64Array:
        """The centre of `bounds`: (3,) float64.

        Raises
        ------
        MeshError
            "a mesh without points has no bounds".
        """
        center: Float64Array = 0.5 * self.bounds[0] + 0.5 * self.bounds[1]
        return _freeze(center)

    def with_attributes(
        self, attributes: AttributesLike | None, *, keep: bool = False, metadata: Mapping[str, Any] | None = None
    ) -> Mesh:
        """Return the mesh of the same points and faces with other attributes.

        Parameters
        ----------
        attributes : Attributes, or a mapping such as {"point": {"color": colors}}, or None
            They take the place of all that the mesh has, or, with `keep`, of those of their names.
        keep : bool
            Whether the mesh keeps its attributes of other names.
        metadata : mapping, optional
            Takes the place of the metadata; they stay if it is None.

        Returns
        -------
        Mesh

        Raises
        ------
        MeshError
            For an attribute with another number of rows.
        """
        mesh = Mesh.__new__(Mesh)
        mesh._positions, mesh._offsets, mesh._indices = self._positions, self._offsets, self._indices
        if keep:
            attributes = self._attributes.updated(as_attributes(attributes))
        mesh._set_attributes(attributes, self._metadata if metadata is None else metadata)
        return mesh

    def reversed(self) -> Mesh:
        """Return the mesh with every face reversed: its first corner stays first, the others come backwards.

        Attributes per corner go along. Segments stay as they are, and so do normals.

        Returns
        -------
        Mesh
        """
        sizes = np.diff(self._offsets)
        starts = np.repeat(self._offsets[:-1], sizes)
        order = np.arange(len(self._indices)) - starts
        order = starts + (np.repeat(sizes, sizes) - order) % np.repeat(sizes, sizes)
        mesh = Mesh.__new__(Mesh)
        mesh._positions, mesh._offsets = self._positions, self._offsets
        mesh._indices = _freeze(self._indices[order])
        mesh._attributes, mesh._metadata = reorder_corners(self._attributes, order), self._metadata
        return mesh

    def transformed(self, matrix: MatrixLike, *, flip: Flip = "auto") -> Mesh:
        """Return the mesh with every point p at `matrix @ (p, 1)`.

        Attributes named "normal" move by the inverse transpose of the matrix and keep their length; those named
        "tangent" move as vectors do; all others stay.

        Parameters
        ----------
        matrix : (4, 4) numbers, or an object with `as_matrix()`
            An affine matrix for column vectors, with the last row (0, 0, 0, 1).
        flip : "auto" or bool
            Whether to reverse the faces, as `reversed` does. "auto" reverses them if the matrix mirrors, that is, if
            its determinant is negative: the faces of a solid still run counter-clockwise as seen from outside.

        Returns
        -------
        Mesh

        Raises
        ------
        ArgumentError
            For another shape or last row, or another `flip`.
        MeshError
            If a coordinate overflows.
        """
        m = as_square_matrix(matrix, "matrix", 4)
        require_affine(m, "matrix")
        with np.errstate(over="ignore", invalid="ignore"):
            positions = self._positions @ m[:3, :3].T + m[:3, 3]
        return move(self, positions, m, flip=flip)

    def to_trimesh(self) -> Any:
        """Return a `trimesh.Trimesh` of the same points, with the polygons as triangles.

        Concave polygons are triangulated correctly. Segments are left out, because a Trimesh cannot hold them.

        Returns
        -------
        trimesh.Trimesh
        """
        import trimesh

        corners, _ = triangulate(self._positions, self._offsets, self._indices)
        return trimesh.Trimesh(vertices=self._positions.copy(), faces=corners, process=False)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        return (
            np.array_equal(self._positions, other._positions)
            and np.array_equal(self._offsets, other._offsets)
            and np.array_equal(self._indices, other._indices)
            and self._attributes == other._attributes
        )

    def __reduce__(self) -> tuple[Any, ...]:
        arrays = self._positions, self._offsets, self._indices
        if not self._attributes and not self._metadata:
            return Mesh.from_offsets, arrays
        return Mesh._restore, (*arrays, self._attributes, thaw_value(self._metadata))

    @classmethod
    def _restore(
        cls,
        positions: npt.ArrayLike,
        offsets: npt.ArrayLike,
        indices: npt.ArrayLike,
        attributes: Attributes,
        metadata: Mapping[str, Any],
    ) -> Mesh:
        """Return the mesh that a pickle holds."""
        return cls.from_offsets(positions, offsets, indices, attributes=attributes, metadata=metadata)

    def __repr__(self) -> str:
        held = self._attributes.summarize()
        return f"<Mesh: {self.n_points} points, {self.n_faces} faces{'; ' if held else ''}{held}>"


def adopt_arrays(
    positions: Float64Array, offsets: IndexArray, indices: IndexArray, attributes: AttributesLike | None = None
) -> Mesh:
    """Return a mesh that takes over finite positions and faces of its points, which are neither copied nor checked."""
    mesh = Mesh.__new__(Mesh)
    mesh._positions, mesh._offsets, mesh._indices = _freeze(positions), _freeze(offsets), _freeze(indices)
    mesh._set_attributes(attributes, None)
    return mesh


def move(mesh: Mesh, positions: npt.ArrayLike, matrix: Float64Array, *, flip: Flip = "auto") -> Mesh:
    """Return `mesh` at `positions`, where the 4x4 `matrix` has put them; as `Mesh.transformed` otherwise."""
    if flip not in ("auto", True, False):
        raise ArgumentError.expecting("flip", "be 'auto', True or False", repr(flip))
    linear = matrix[:3, :3]
    moved = Mesh.__new__(Mesh)
    moved._positions = _freeze(_validate_positions(positions))
    moved._offsets, moved._indices, moved._metadata = mesh._offsets, mesh._indices, mesh._metadata
    moved._attributes = transform_attributes(mesh._attributes, linear) if mesh._attributes else NO_ATTRIBUTES
    return moved.reversed() if (sign_of_determinant(matrix) < 0 if flip == "auto" else flip) else moved


def pack_pairs(a: IndexArray, b: IndexArray) -> npt.NDArray[np.uint64]:
    """Return one key per unordered pair of indices, which sorts as the pair with its lower index first: (n,)."""
    low, high = np.minimum(a, b).astype(np.uint64), np.maximum(a, b).astype(np.uint64)
    return (low << np.uint64(32)) | high


def unpack_pairs(keys: npt.NDArray[np.uint64]) -> IndexArray:
    """Return the pairs that `pack_pairs` made keys of, the lower index first: (n, 2)."""
    return np.stack([keys >> np.uint64(32), keys & np.uint64(0xFFFFFFFF)], axis=1).astype(np.int64)


def _freeze(array: _Array) -> _Array:
    array.flags.writeable = False
    return array


def _require_unmasked(values: object, name: str) -> None:
    """Raise MeshError for an array of which a mask hides a number."""
    try:
        require_unmasked(values, name)
    except ArgumentError as error:
        raise MeshError(str(error)) from None


def _validate_positions(positions: npt.ArrayLike) -> Float64Array:
    """Return a new (n, 3) float64 array of `positions`."""
    _require_unmasked(positions, "positions")
    try:
        array = np.asarray(positions)
    except ValueError as error:  # a ragged list
        raise MeshError(f"positions must have shape (n, 3): {error}") from None
    if array.size == 0 and array.ndim < 2:
        array = np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"positions must have shape (n, 3), got {array.shape}")
    if array.dtype.kind not in "fiu":
        raise MeshError(f"positions must hold real numbers, got dtype {array.dtype}")
    if len(array) > _MAX_POINTS:
        raise MeshError(f"a mesh holds at most {_MAX_POINTS} points, got {len(array)}")
    result = np.array(array, dtype=np.float64, order="C")
    if not np.isfinite(result).all():
        raise MeshError(f"positions must be finite, got {describe_first_non_finite(result)}")
    return result


def _flatten_faces(faces: FacesLike) -> tuple[IndexArray, IndexArray]:
    """Return (offsets, indices) of faces given as an array (f, k) or as a list of lists."""
    if isinstance(faces, np.ndarray):
        if faces.size == 0 and faces.ndim < 2:
            return np.zeros(1, np.int64), np.zeros(0, np.int64)
        rectangle = _as_integers(faces, "faces", 2)
        count, size = rectangle.shape
        return np.arange(count + 1) * size, np.array(rectangle).ravel()
    try:
        rows: list[Any] = list(faces)  # type: ignore[arg-type]
        sizes = np.fromiter(map(len, rows), np.int64, len(rows))
        flat = list(chain.from_iterable(rows))
    except TypeError as error:
        raise MeshError(f"faces must be lists of indices: {error}") from None
    offsets = np.zeros(len(rows) + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    return offsets, _as_integers(flat, "indices", 1)


def _as_integers(values: npt.ArrayLike, name: str, ndim: int) -> IndexArray:
    """Return `values` as int64 with `ndim` dimensions, not necessarily copied."""
    _require_unmasked(values, name)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise MeshError(f"{name} must be integers: {error}") from None
    if array.ndim != ndim:
        raise MeshError(f"{name} must have {ndim} dimension{'s'[: ndim - 1]}, got shape {array.shape}")
    if array.size == 0:
        return array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise MeshError(f"{name} must be integers, got dtype {array.dtype}")
    if array.dtype == np.uint64 and array.max() > np.iinfo(np.int64).max:
        raise MeshError(f"{name} must be integers below 2**63, got {array.max()}")
    return array.astype(np.int64, copy=False)


def _require_offsets(offsets: IndexArray, n_indices: int) -> None:
    """Raise MeshError unless the offsets split `n_indices` corners into faces of two or more."""
    if len(offsets) == 0 or offsets[0] != 0 or offsets[-1] != n_indices:
        ends = "nothing" if len(offsets) == 0 else f"{offsets[0]} to {offsets[-1]}"
        raise MeshError(f"offsets must run from 0 to {n_indices}, the number of indices, got {ends}")
    sizes = np.diff(offsets)
    if (sizes < 2).any():
        face = int(np.argmax(sizes < 2))
        raise MeshError(f"face {face} has {sizes[face]} corners, a face needs at least 2")


def _require_indices(indices: IndexArray, offsets: IndexArray, n_points: int) -> None:
    """Raise MeshError unless every index names a point."""
    if len(indices) == 0 or (indices.min() >= 0 and indices.max() < n_points):
        return
    corner = int(np.argmax((indices < 0) | (indices >= n_points)))
    face = int(np.searchsorted(offsets, corner, side="right")) - 1
    raise MeshError(f"face {face} names point {indices[corner]}, outside 0..{n_points - 1} ({n_points} points)")
