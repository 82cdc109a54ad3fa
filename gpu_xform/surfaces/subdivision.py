"""Subdivision surfaces: a mesh refined level by level, and the matrix that does the same to a deformed cage."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Literal, SupportsIndex, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_int, as_real_array
from .._core.interrupts import defer_interrupts
from .._core.public import public
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MissingExtraError
from ..geometry.attributes import Attributes, Columns, take_rows
from ..geometry.mesh import Mesh, adopt_arrays
from .cage import Cage, add_creases, make_cage, require_manifold
from .refine import Sparse, divide_into_quads, divide_into_triangles, refine_catmull_clark, refine_loop
from .resolution import MAX_FACES

Scheme: TypeAlias = Literal["catmull-clark", "loop"]

_SCHEMES: dict[str, tuple[Callable[[Cage], Sparse], Callable[[Cage], Cage]]] = {
    "catmull-clark": (refine_catmull_clark, divide_into_quads),
    "loop": (refine_loop, divide_into_triangles),
}


@public
class Subdivision:
    """A subdivided mesh, and the linear map from the points of its cage to its own; `subdivide` makes it.

    The faces do not depend on where the points are. For a cage that moves, `matrix @ points` is the whole surface of a
    frame, and `deformed(points)` its mesh.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, cage: Mesh, levels: list[Sparse], mesh: Mesh) -> None:
        self._cage, self._levels, self._mesh = cage, levels, mesh

    @property
    def cage(self) -> Mesh:
        """The mesh that was subdivided."""
        return self._cage

    @property
    def mesh(self) -> Mesh:
        """The result, with attributes."""
        return self._mesh

    @cached_property
    def matrix(self) -> Any:
        """The product of all levels: a `scipy.sparse.csr_array` (m, n), whose rows sum up to 1.

        Row i holds the weights of the n points of the cage in point i of the result.
        """
        from scipy.sparse import eye_array

        product = eye_array(self._cage.n_points, format="csr")
        for level in self._levels:
            product = level @ product
        product.eliminate_zeros()
        return product

    def deformed(self, positions: npt.ArrayLike) -> Mesh:
        """Return the surface of the same cage with its points elsewhere.

        Parameters
        ----------
        positions : (n, 3) numbers
            The points of the cage.

        Returns
        -------
        Mesh
            The faces of `mesh`, without attributes.

        Raises
        ------
        ArgumentError
            For another shape, or a coordinate that is not finite.
        """
        points = as_real_array(positions, "positions")
        if points.shape != (self._cage.n_points, 3):
            raise ArgumentError.expecting("positions", f"have shape ({self._cage.n_points}, 3)", points.shape)
        return adopt_arrays(self.matrix @ points, self._mesh.offsets, self._mesh.indices)

    def __repr__(self) -> str:
        return f"<Subdivision: {len(self._levels)} levels, {self._cage.n_points} to {self._mesh.n_points} points>"


@public
def subdivide(
    mesh: Mesh,
    levels: SupportsIndex = 1,
    scheme: Scheme = "catmull-clark",
    *,
    creases: npt.ArrayLike = (),
    sharpness: npt.ArrayLike = np.inf,
    corners: npt.ArrayLike = (),
) -> Subdivision:
    """Subdivide a mesh, each level a sparse matrix; needs the extra `surfaces`.

    A border becomes a B-spline curve; a crease does the same within a surface.

    Parameters
    ----------
    mesh : Mesh
        The cage: polygons that form a manifold, with or without borders; triangles for "loop". Attributes go along: per
        point they are multiplied by the same matrix, per corner they are interpolated within the faces of the cage, and
        faces inherit those of theirs. "normal" is scaled to length 1, and whole numbers are rounded. Texts, truth
        values, ragged arrays and numbers with labels, which cannot be interpolated, go along per face only.
    levels : int
        How often to subdivide, at least 0. Each level has four times as many faces as the one before; the first one of
        Catmull and Clark has one per corner.
    scheme : "catmull-clark" or "loop"
        Catmull and Clark's scheme turns polygons of any size into quads; Loop's divides triangles into four.
    creases : (m, 2) integers
        Edges that stay sharp, by their points.
    sharpness : float, or (m,) numbers of at least 0
        For how many levels each crease is sharp, 10 or more for all; fractions are blended.
    corners : (c,) integers
        Points that stay where they are, such as the corners of a border.

    Returns
    -------
    Subdivision
        With `mesh`, the result, and `matrix`, which maps the points of a deformed cage.

    Raises
    ------
    ArgumentError
        For a mesh that is no manifold, such as "mesh must be a manifold, got edge 3-7 of 3 faces", for a crease that is
        no edge, and if more than 2^24 faces were needed.
    ArgumentTypeError
        If `mesh` is no Mesh.
    MissingExtraError
        If SciPy is not installed.

    Notes
    -----
    Sources: E. Catmull, J. Clark (1978), C. Loop (1987), and for creases T. DeRose et al. (1998). The rules are those
    of OpenSubdiv, with uniform creases and smooth corners of borders.
    """
    if not isinstance(mesh, Mesh):
        raise ArgumentTypeError.expecting("mesh", "be a Mesh", type(mesh).__name__)
    if scheme not in _SCHEMES:
        got = f"{scheme!r}{did_you_mean(str(scheme), list(_SCHEMES))}"
        raise ArgumentError.expecting("scheme", "be 'catmull-clark' or 'loop'", got)
    n_levels = as_int(levels, "levels")
    if n_levels < 0:
        raise ArgumentError.expecting("levels", "be at least 0", n_levels)
    _require_scipy()
    is_loop = scheme == "loop"
    # Of no larger power, which itself would take for ever.
    n_faces = mesh.n_faces * 4 ** min(n_levels, 30) if is_loop else len(mesh.indices) * 4 ** min(n_levels - 1, 30)
    if n_levels and n_faces > MAX_FACES:
        needed = f"{n_faces}" if n_levels <= 30 else "far more"
        raise ArgumentError.expecting(
            "levels", f"need at most {MAX_FACES} faces", n_levels, reason=f"it needs {needed}"
        )
    cage = make_cage(mesh.n_points, mesh.offsets, mesh.indices)
    require_manifold(cage, "mesh")
    if is_loop and (cage.sizes != 3).any():
        face = int(np.argmax(cage.sizes != 3))
        raise ArgumentError.expecting("mesh", "have triangles alone", f"face {face} of {cage.sizes[face]} corners")
    cage = add_creases(cage, creases, sharpness, corners)
    refine, divide = _SCHEMES[scheme]
    positions, matrices, attributes = mesh.positions, [], mesh.attributes
    for _ in range(n_levels):
        matrix = refine(cage)
        positions = matrix @ positions
        matrices.append(matrix)
        if attributes:
            attributes = _refine_attributes(attributes, cage, matrix, is_loop=is_loop)
        cage = divide(cage)
    result = adopt_arrays(positions, cage.offsets, cage.indices, attributes) if n_levels else mesh
    return Subdivision(mesh, matrices, result)


def _require_scipy() -> None:
    """Raise MissingExtraError unless SciPy can be imported."""
    try:
        with defer_interrupts():
            import scipy.sparse  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("subdivide needs SciPy: pip install 'gpu_xform[surfaces]'") from error


def _refine_attributes(attributes: Attributes, cage: Cage, matrix: Sparse, *, is_loop: bool) -> Attributes:
    """Return the attributes of the next level."""
    labels = attributes.labels

    def refine(table: Columns, interpolate: Callable[[Float64Array], Float64Array]) -> dict[str, Any]:
        columns = {}
        for name, column in table.items():
            if isinstance(column, np.ndarray) and column.dtype.kind in "iuf" and name not in labels:
                rows = interpolate(column.reshape(len(column), -1).astype(np.float64))
                columns[name] = _round_to(rows.reshape(-1, *column.shape[1:]), name, column.dtype)
        return columns

    parent = np.repeat(np.arange(cage.n_faces), 4) if is_loop else cage.face
    face = {name: take_rows(column, parent) for name, column in attributes.face.items()}
    corner = refine(attributes.corner, lambda rows: _interpolate_corners(rows, cage, is_loop=is_loop))
    point = refine(attributes.point, lambda rows: np.asarray(matrix @ rows))
    kept = {name: texts for name, texts in labels.items() if name in face}
    return Attributes(point, corner, face, labels=kept, material=attributes.material)


def _interpolate_corners(rows: Float64Array, cage: Cage, *, is_loop: bool) -> Float64Array:
    """Return rows per corner of the next level, linear within the faces of this one."""
    middles = 0.5 * (rows + rows[cage.following])  # of the edge behind each corner
    if is_loop:
        (a, b, c), (ab, bc, ca) = (table.reshape(-1, 3, rows.shape[1]).swapaxes(0, 1) for table in (rows, middles))
        return np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, rows.shape[1])
    means = np.add.reduceat(rows, cage.offsets[:-1], axis=0) / cage.sizes[:, np.newaxis]
    return np.stack([rows, middles, means[cage.face], middles[cage.preceding]], axis=1).reshape(-1, rows.shape[1])


def _round_to(rows: Float64Array, name: str, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """Return interpolated rows in the type of the attribute, and normals with length 1."""
    if dtype.kind in "iu":
        limits = np.iinfo(dtype)
        return np.clip(np.rint(rows), limits.min, limits.max).astype(dtype)
    if name == "normal" and rows.ndim == 2 and rows.shape[1] == 3:
        lengths = np.linalg.norm(rows, axis=1, keepdims=True)
        rows = rows / np.where(lengths > 0, lengths, 1.0)
    return rows.astype(dtype)
