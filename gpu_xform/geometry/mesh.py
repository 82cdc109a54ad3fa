"""Polygon meshes: positions, and faces of any size in flat arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import chain
from types import MappingProxyType
from typing import Any, Literal, TypeAlias, TypeGuard

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, describe_first_non_finite, require_affine, require_room
from .._core.interrupts import defer_interrupts
from .._core.masked import drop_hidden_rows, require_whole
from .._core.pictured import Pictured
from .._core.public import public
from .._core.types import Float64Array, IndexArray, MatrixLike
from .._core.widen import widen
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
from .face_list import FaceList, freeze
from .face_list import pack_pairs as pack_pairs
from .face_list import unpack_pairs as unpack_pairs
from .triangulation import triangulate

FacesLike: TypeAlias = npt.ArrayLike | Sequence[npt.ArrayLike]
Flip: TypeAlias = Literal["auto"] | bool

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
        face_list = _flatten_faces(faces)
        shown = drop_hidden_rows(positions) if face_list.n_corners == 0 else positions
        self._set(_validate_positions(shown), face_list)
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
        starts, corners = _as_int64(offsets, "offsets", 1), _as_integers(indices, "indices", 1)
        mesh._set(_validate_positions(positions), _list_faces(np.array(starts), corners.view()))
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

    def _set(self, positions: Float64Array, faces: FaceList, *, is_own: bool = False) -> None:
        """Validate the corners, take over positions, and faces if nobody else holds them, else a copy of these."""
        _require_indices(faces, len(positions))
        self._positions = freeze(positions)
        self._faces = faces if is_own and faces.corners.dtype == np.uint32 else _compact(faces)

    def _set_attributes(self, attributes: AttributesLike | None, metadata: Mapping[str, Any] | None) -> None:
        """Validate the attributes, and take them and the metadata over as read-only ones."""
        self._attributes = as_attributes(attributes)
        if self._attributes:
            require_rows(self._attributes, self.n_points, self._faces.n_corners, self.n_faces)
        self._metadata = freeze_value(metadata) if metadata else _NO_METADATA

    @property
    def positions(self) -> Float64Array:
        """The points: (n, 3) float64."""
        return self._positions

    @property
    def offsets(self) -> IndexArray:
        """Where each face starts in `indices`: (f + 1,) int64."""
        return self._faces.offsets

    @property
    def indices(self) -> IndexArray:
        """The corners of all faces, one face after the other: (c,) int64."""
        return self._faces.indices

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
        return self._faces.n_faces

    @cached_property
    def faces(self) -> IndexArray | tuple[IndexArray, ...]:
        """The faces: (f, k) int64 if all have k corners, else a tuple of (k_i,) int64; () if there are none.

        Either way, `len`, `[i]` and iteration give one array per face, and `Mesh(positions, mesh.faces)` accepts it.
        """
        if self.n_faces == 0:
            return ()
        sizes = np.diff(self.offsets) if self._faces.size is None else np.array([self._faces.size])
        if (sizes == sizes[0]).all():
            return self.indices.reshape(-1, int(sizes[0]))
        return tuple(np.split(self.indices, self.offsets[1:-1]))

    @property
    def face_edges(self) -> IndexArray:
        """The directed edges of every face, in the order of the faces: (h, 2) int64.

        A polygon of k corners gives its k edges (c0, c1), (c1, c2), ..., (ck-1, c0); a segment gives (c0, c1) alone.
        An edge that two faces share appears once for each; `face_edge_faces` holds the face of each row.
        """
        return self._faces.half_edges[0]

    @property
    def face_edge_faces(self) -> IndexArray:
        """The face of each row of `face_edges`: (h,) int64, ascending."""
        return self._faces.half_edges[1]

    @cached_property
    def last_face_edges(self) -> IndexArray:
        """The last row of `face_edges` for each edge, in either direction: (m,) int64, ascending."""
        _, from_last = np.unique(pack_pairs(*self.face_edges[::-1].T), return_index=True)
        return freeze(np.sort(len(self.face_edges) - 1 - from_last))

    @property
    def edges(self) -> IndexArray:
        """The edges of all faces, each once: (m, 2) int64, lower index first, sorted.

        An edge from a point to itself, as a corner repeated in succession makes it, is left out.
        """
        return self._faces.edges

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
        return freeze(corners)

    @cached_property
    def used_positions(self) -> Float64Array:
        """The points that faces use, in their order, or all points of a mesh without faces: (k, 3) float64."""
        if self.n_faces == 0:
            return self._positions
        is_used = np.zeros(self.n_points, np.bool_)
        is_used[self._faces.corners] = True
        return self._positions if is_used.all() else freeze(self._positions[is_used])

    @cached_property
    def center(self) -> Float64Array:
        """The centre of `bounds`: (3,) float64.

        Raises
        ------
        MeshError
            "a mesh without points has no bounds".
        """
        center: Float64Array = 0.5 * self.bounds[0] + 0.5 * self.bounds[1]
        return freeze(center)

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
        mesh._positions, mesh._faces = self._positions, self._faces
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
        order = order_reversed(self.offsets)
        mesh = Mesh.__new__(Mesh)
        mesh._positions = self._positions
        offsets = None if self._faces.size else self.offsets
        mesh._faces = FaceList(self._faces.corners[order], size=self._faces.size, offsets=offsets)
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
        if np.array_equal(m, np.eye(4)) and not (np.signbit(self._positions) & (self._positions == 0.0)).any():
            return self if flip == "auto" else move(self, self._positions, m, flip=flip)  # 0.0 would come of -0.0
        with np.errstate(over="ignore", invalid="ignore"):
            positions = self._positions @ m[:3, :3].T
            positions += m[:3, 3]
        _require_finite(positions)
        return move(self, freeze(positions), m, flip=flip)

    def to_trimesh(self) -> Any:
        """Return a `trimesh.Trimesh` of the same points, with the polygons as triangles, and with colours in uint8.

        Concave polygons are triangulated correctly. Segments are left out, because a Trimesh cannot hold them.

        Returns
        -------
        trimesh.Trimesh
        """
        with defer_interrupts():
            import trimesh

        corners, faces = triangulate(self._positions, self.offsets, self.indices)
        colors: dict[str, Any] = {}
        for name, table, rows in (
            ("vertex_colors", self.attributes.point, slice(None)),
            ("face_colors", self.attributes.face, faces),
        ):
            column = table.get("color")
            if isinstance(column, np.ndarray) and column.dtype == np.uint8 and not colors:
                colors[name] = column[rows].copy()
        return trimesh.Trimesh(vertices=self._positions.copy(), faces=corners, process=False, **colors)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        return (
            np.array_equal(self._positions, other._positions)
            and self._faces == other._faces
            and self._attributes == other._attributes
        )

    def __reduce__(self) -> tuple[Any, ...]:
        arrays = self._positions, self.offsets, self.indices
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
    mesh._positions, mesh._faces = freeze(positions), FaceList(indices, offsets=offsets)
    mesh._set_attributes(attributes, None)
    return mesh


def take_over(
    positions: Float64Array,
    faces: npt.NDArray[Any] | tuple[IndexArray, npt.NDArray[Any]],
    *,
    attributes: AttributesLike | None = None,
    metadata: Mapping[str, Any] | None = None,
) -> Mesh:
    """Return the mesh of positions (n, 3) that nobody else holds, checked as `Mesh` does, and not copied.

    faces : integers (f, k), or offsets and indices as `Mesh.from_offsets` takes them; uint32 ones are not copied either
    """
    mesh = Mesh.__new__(Mesh)
    _require_finite(positions)
    mesh._set(positions, _list_faces(*faces) if isinstance(faces, tuple) else _flatten_faces(faces), is_own=True)
    mesh._set_attributes(attributes, metadata)
    return mesh


def order_reversed(offsets: IndexArray) -> IndexArray:
    """Return the corners of faces in the order of `Mesh.reversed`."""
    sizes = np.diff(offsets)
    starts = np.repeat(offsets[:-1], sizes)
    order = np.arange(len(starts)) - starts
    reversed_order: IndexArray = starts + (np.repeat(sizes, sizes) - order) % np.repeat(sizes, sizes)
    return reversed_order


def count_corners(mesh: Mesh) -> int:
    """Return the number of corners of all faces."""
    return mesh._faces.n_corners


def count_edges(mesh: Mesh) -> int:
    """Return the number of `mesh.edges`."""
    return len(mesh._faces.edge_keys)


def pack_edges(mesh: Mesh) -> npt.NDArray[np.uint32]:
    """Return `mesh.edges` as uint32 (m, 2), which takes half of their memory, and keeps none."""
    return mesh._faces.pack_edges()


def move(mesh: Mesh, positions: npt.ArrayLike, matrix: Float64Array, *, flip: Flip = "auto") -> Mesh:
    """Return `mesh` at `positions`, where the 4x4 `matrix` has put them; as `Mesh.transformed` otherwise."""
    if flip not in ("auto", True, False):
        raise ArgumentError.expecting("flip", "be 'auto', True or False", repr(flip))
    linear = matrix[:3, :3]
    moved = Mesh.__new__(Mesh)
    moved._positions = positions if is_own(positions) else freeze(_validate_positions(positions))
    moved._faces, moved._metadata = mesh._faces, mesh._metadata
    moved._attributes = transform_attributes(mesh._attributes, linear) if mesh._attributes else NO_ATTRIBUTES
    return moved.reversed() if (sign_of_determinant(matrix) < 0 if flip == "auto" else flip) else moved


def is_own(positions: npt.ArrayLike) -> TypeGuard[Float64Array]:
    """Say whether positions are an array that nobody can write into, as those of meshes are."""
    is_array = type(positions) is np.ndarray and positions.dtype == np.float64 and positions.ndim == 2
    return is_array and positions.base is None and not positions.flags.writeable  # type: ignore[union-attr]


def _require_whole(values: object, name: str) -> None:
    """Raise MeshError for an array of which a mask hides a number."""
    try:
        require_whole(values, name)
    except ArgumentError as error:
        raise MeshError(str(error)) from None


def _validate_positions(positions: npt.ArrayLike) -> Float64Array:
    """Return a new (n, 3) float64 array of `positions`."""
    _require_whole(positions, "positions")
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
    result = widen(array)
    _require_finite(result)
    return result


def _require_finite(positions: Float64Array) -> None:
    if not np.isfinite(positions).all():
        raise MeshError(f"positions must be finite, got {describe_first_non_finite(positions)}")


def _flatten_faces(faces: FacesLike) -> FaceList:
    """Return faces given as an array (f, k) or as a list of lists."""
    if hasattr(faces, "__array__") and not isinstance(faces, np.ndarray):
        _require_whole(faces, "faces")
        faces = np.asarray(faces)
    if isinstance(faces, np.ndarray):
        if faces.size == 0 and faces.ndim < 2:
            return FaceList(np.zeros(0, np.uint32), offsets=np.zeros(1, np.int64))
        rectangle = _as_integers(faces, "faces", 2)
        count, size = rectangle.shape
        if count == 0 or size < 2:
            return _list_faces(np.arange(count + 1) * size, rectangle.ravel())
        return FaceList(rectangle.reshape(-1), size=size)
    try:
        rows: list[Any] = list(faces)  # type: ignore[arg-type]
        sizes = np.fromiter(map(len, rows), np.int64, len(rows))
        flat = list(chain.from_iterable(rows))
    except TypeError as error:
        raise MeshError(f"faces must be lists of indices: {error}") from None
    offsets = np.zeros(len(rows) + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    return _list_faces(offsets, _as_integers(flat, "indices", 1))


def _list_faces(offsets: IndexArray, indices: npt.NDArray[Any]) -> FaceList:
    """Return the faces of offsets and indices; raise MeshError if these do not fit one another."""
    _require_offsets(offsets, len(indices))
    sizes = np.diff(offsets)
    is_one_size = len(sizes) > 0 and bool((sizes == sizes[0]).all())
    return FaceList(indices, size=int(sizes[0]) if is_one_size else None, offsets=None if is_one_size else offsets)


def _compact(faces: FaceList) -> FaceList:
    """Return faces of valid corners with a copy of these as uint32."""
    offsets = None if faces.size else faces.offsets
    return FaceList(faces.corners.astype(np.uint32), size=faces.size, offsets=offsets)


def _as_int64(values: npt.ArrayLike, name: str, ndim: int) -> IndexArray:
    """Return `values` as int64 with `ndim` dimensions, not necessarily copied."""
    return _as_integers(values, name, ndim).astype(np.int64, copy=False)


def _as_integers(values: npt.ArrayLike, name: str, ndim: int) -> npt.NDArray[Any]:
    """Return `values` as integers that int64 holds, with `ndim` dimensions, not necessarily copied."""
    _require_whole(values, name)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise MeshError(f"{name} must be integers: {error}") from None
    require_room(array, name)
    if array.ndim != ndim:
        raise MeshError(f"{name} must have {ndim} dimension{'s'[: ndim - 1]}, got shape {array.shape}")
    if array.size == 0:
        return array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise MeshError(f"{name} must be integers, got dtype {array.dtype}")
    if array.dtype == np.uint64 and array.max() > np.iinfo(np.int64).max:
        raise MeshError(f"{name} must be integers below 2**63, got {array.max()}")
    return array


def _require_offsets(offsets: IndexArray, n_indices: int) -> None:
    """Raise MeshError unless the offsets split `n_indices` corners into faces of two or more."""
    if len(offsets) == 0 or offsets[0] != 0 or offsets[-1] != n_indices:
        ends = "nothing" if len(offsets) == 0 else f"{offsets[0]} to {offsets[-1]}"
        raise MeshError(f"offsets must run from 0 to {n_indices}, the number of indices, got {ends}")
    sizes = np.diff(offsets)
    if (sizes < 2).any():
        face = int(np.argmax(sizes < 2))
        raise MeshError(f"face {face} has {sizes[face]} corners, a face needs at least 2")


def _require_indices(faces: FaceList, n_points: int) -> None:
    """Raise MeshError unless every corner names a point."""
    indices = faces.corners
    if len(indices) == 0 or (indices.min() >= 0 and indices.max() < n_points):
        return
    corner = int(np.argmax((indices < 0) | (indices >= n_points)))
    face = int(np.searchsorted(faces.offsets, corner, side="right")) - 1
    raise MeshError(f"face {face} names point {indices[corner]}, outside 0..{n_points - 1} ({n_points} points)")
