"""The spring system: points with masses, and the springs between them, validated; nothing of it changes."""

import hashlib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError, SimulationWarning
from ..geometry.mesh import Mesh
from ._validation import (
    as_column,
    as_index_array,
    as_nonnegative_float,
    as_point_indices,
    as_points,
    as_positive_float,
    require_each,
)
from .mesh_springs import list_mesh_springs, list_triangles, share_areas

MIN_MASS_KG = 1e-38
MAX_ROUNDING_STRAIN = 0.01  # of springs, by the rounding of positions to float32


@dataclass(frozen=True, eq=False)
class SpringSystem:
    """Points of n, joined by s springs.

    points : (n, 3), in metres, at the start
    masses : (n,), in kilograms
    pinned : (n,), the points that no force moves
    pairs : (s, 2), the ends of each spring
    stiffness : (s,), in newtons per metre
    rest : (s,), in metres
    damping_s : each spring has a damper of this many seconds times its stiffness
    triangles : (t, 3), the faces, on which air drags
    mesh : what is drawn of it
    """

    points: Float64Array
    masses: Float64Array
    pinned: BoolArray
    pairs: IndexArray
    stiffness: Float64Array
    rest: Float64Array
    damping_s: float
    triangles: IndexArray
    mesh: Mesh

    @property
    def n_points(self) -> int:
        """The number of points."""
        return len(self.points)

    @property
    def inverse_masses(self) -> Float64Array:
        """One over each mass, 0 for pinned points: (n,), in 1/kg."""
        return np.where(self.pinned, 0.0, 1.0 / self.masses)

    @cached_property
    def max_area_per_mass(self) -> float:
        """The largest area per mass of a free point, to which each triangle gives a third of its own, in m^2/kg."""
        a, b, c = self.points[self.triangles].transpose(1, 0, 2)
        thirds = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
        shares = np.bincount(self.triangles.ravel(), np.repeat(thirds, 3), self.n_points)
        return float((shares * self.inverse_masses).max())

    def describe_parts(self) -> dict[str, str]:
        """Return a text of each part that another system, whose part differs, does not have."""
        arrays = {
            "points": self.points,
            "springs": self.pairs,
            "faces": self.triangles,
            "masses": self.masses,
            "pins": self.pinned,
            "stiffness": self.stiffness,
            "rest lengths": self.rest,
        }
        digests = {name: f"{len(each)} {hashlib.sha256(each.tobytes()).hexdigest()}" for name, each in arrays.items()}
        return digests | {"damping": repr(self.damping_s)}

    def fingerprint(self) -> str:
        """Return a text that no other system has."""
        digest = hashlib.sha256()
        for array in (self.points, self.masses, self.pinned, self.pairs, self.stiffness, self.rest, self.triangles):
            digest.update(f"{array.shape}".encode() + array.tobytes())
        digest.update(repr(self.damping_s).encode())
        return digest.hexdigest()


def make_system(
    model: Mesh | npt.ArrayLike,
    *,
    springs: npt.ArrayLike | None,
    stiffness: npt.ArrayLike | None,
    rest: npt.ArrayLike | None,
    stretch: float | None,
    shear: float,
    bend: float,
    mass: npt.ArrayLike | None,
    area_density: npt.ArrayLike | None,
    damping: float,
    pinned: npt.ArrayLike,
) -> SpringSystem:
    """Return the system that the arguments of `Springs` describe. Raises as `Springs` does."""
    mesh = model if isinstance(model, Mesh) else None
    points = as_points(mesh.positions if mesh else model, "model")  # type: ignore[arg-type]  # no mesh, so an array
    n_points = len(points)
    if n_points == 0:
        raise ArgumentError.expecting("model", "have at least one point", "none")
    groups = [_list_given(points, springs, stiffness, rest)]
    if mesh is not None:
        groups.insert(0, _list_of_mesh(mesh, stretch, shear, bend, is_required=springs is None))
    elif stretch is not None or shear or bend:
        raise ArgumentError("stretch, shear and bend need a mesh, whose edges and faces they join", argument="stretch")
    pairs, k, lengths = (np.concatenate(columns) for columns in zip(*groups, strict=True))
    system = SpringSystem(
        points,
        _as_masses(mesh, n_points, mass, area_density),
        _as_mask(pinned, n_points),
        pairs,
        k,
        lengths,
        as_nonnegative_float(damping, "damping"),
        np.empty((0, 3), np.int64) if mesh is None else list_triangles(mesh),
        Mesh(points, pairs) if mesh is None else mesh,
    )
    if system.pinned.all():
        raise ArgumentError.expecting("pinned", "leave a point free", f"all {n_points}")
    return system


def join_systems(systems: Sequence[SpringSystem]) -> SpringSystem:
    """Return the system of all points and springs of several; the points follow one another."""
    damping = {system.damping_s for system in systems}
    if len(damping) > 1:
        raise ArgumentError.expecting("damping", "be the same for all that are joined", sorted(damping))
    starts = np.cumsum([0, *(system.n_points for system in systems[:-1])])

    def concatenate(name: str) -> Any:
        return np.concatenate([getattr(system, name) for system in systems])

    def shift(name: str) -> IndexArray:
        return np.concatenate([getattr(each, name) + start for each, start in zip(systems, starts, strict=True)])

    meshes = [system.mesh for system in systems]
    offsets = np.concatenate([[0], *(np.diff(mesh.offsets) for mesh in meshes)]).cumsum()
    indices = np.concatenate([mesh.indices + start for mesh, start in zip(meshes, starts, strict=True)])
    return SpringSystem(
        concatenate("points"),
        concatenate("masses"),
        concatenate("pinned"),
        shift("pairs"),
        concatenate("stiffness"),
        concatenate("rest"),
        systems[0].damping_s,
        shift("triangles"),
        Mesh.from_offsets(concatenate("points"), offsets, indices),
    )


Springs = tuple[IndexArray, Float64Array, Float64Array]  # pairs, stiffness, rest


def _list_given(
    points: Float64Array, springs: npt.ArrayLike | None, stiffness: npt.ArrayLike | None, rest: npt.ArrayLike | None
) -> Springs:
    """Return the springs that are given one by one."""
    if springs is None:
        if stiffness is not None or rest is not None:
            raise ArgumentError("stiffness and rest are those of springs, which are not given", argument="springs")
        return np.empty((0, 2), np.int64), np.empty(0), np.empty(0)
    pairs = _as_pairs(springs, len(points))
    if stiffness is None:
        raise ArgumentError.expecting("stiffness", "be given with springs, in newtons per metre", "none")
    k = as_column(stiffness, "stiffness", len(pairs), "spring")
    require_each(k >= 0.0, "stiffness", "not be negative", k, "spring")
    lengths = _measure(points, pairs, "springs")
    if rest is not None:
        lengths = as_column(rest, "rest", len(pairs), "spring")
        require_each(lengths > 0.0, "rest", "be positive", lengths, "spring")
    return pairs, k, lengths


def _list_of_mesh(mesh: Mesh, stretch: float | None, shear: float, bend: float, *, is_required: bool) -> Springs:
    """Return the springs along the edges and across the faces of a mesh; none if only given ones are wanted."""
    names = ("stretch", "shear", "bend")
    if stretch is None:
        if is_required:
            raise ArgumentError.expecting("stretch", "be given for a mesh, in newtons per metre", "none")
        stretch = 0.0
    constants = [as_nonnegative_float(k, name) for k, name in zip((stretch, shear, bend), names, strict=True)]
    lists = [
        pairs if constant else pairs[:0] for pairs, constant in zip(list_mesh_springs(mesh), constants, strict=True)
    ]
    pairs = np.concatenate(lists)
    return (
        pairs,
        np.repeat(np.array(constants), [len(each) for each in lists]),
        _measure(mesh.positions, pairs, "model"),
    )


def _measure(points: Float64Array, pairs: IndexArray, name: str) -> Float64Array:
    """Return the length of each spring (s,); raise ArgumentError if one has none."""
    lengths: Float64Array = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    rounded = points.astype(np.float32).astype(np.float64)  # as the device holds them
    kept = np.linalg.norm(rounded[pairs[:, 0]] - rounded[pairs[:, 1]], axis=1)
    if (kept == 0.0).any():
        a, b = pairs[int(np.argmin(np.minimum(lengths, kept)))].tolist()
        where = f" as float32, near {points[a].tolist()}" if (lengths > 0.0).all() else ""
        raise ArgumentError.expecting(name, "join points that lie apart", f"points {a} and {b} in one place{where}")
    strains = np.abs(kept - lengths) / lengths
    if strains.max(initial=0.0) > MAX_ROUNDING_STRAIN:
        a, b = pairs[int(np.argmax(strains))].tolist()
        warnings.warn(
            f"float32, in which the device holds positions, changes the distance of points {a} and {b} by "
            f"{100.0 * strains.max():.2g} %, as they are far from the origin: move the model nearer to it",
            SimulationWarning,
            stacklevel=5,  # the caller of `Springs`
        )
    return lengths


def _as_pairs(springs: npt.ArrayLike, n_points: int) -> IndexArray:
    """Return pairs of different points (s, 2)."""
    array = as_index_array(springs, "springs")
    if array.size == 0:
        return np.empty((0, 2), np.int64)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ArgumentError.expecting("springs", "have shape (s, 2)", array.shape)
    if array.dtype.kind not in "iu":
        raise ArgumentTypeError.expecting("springs", "hold indices of points", f"dtype {array.dtype}")
    outside = ((array < 0) | (array >= n_points)).any(axis=1)
    if outside.any():
        row = int(np.argmax(outside))
        raise ArgumentError.expecting(
            "springs", f"name points in 0..{n_points - 1}", f"{tuple(array[row].tolist())} for spring {row}"
        )
    pairs = array.astype(np.int64)
    loops = pairs[:, 0] == pairs[:, 1]
    if loops.any():
        row = int(np.argmax(loops))
        raise ArgumentError.expecting(
            "springs", "join two points each", f"point {pairs[row, 0]} twice for spring {row}"
        )
    return pairs


def _as_masses(
    mesh: Mesh | None, n_points: int, mass: npt.ArrayLike | None, area_density: npt.ArrayLike | None
) -> Float64Array:
    """Return the mass of each point (n,), in kilograms."""
    if (mass is None) == (area_density is None):
        raise ArgumentError(
            f"mass (kg) or area_density (kg/m^2) must be given, got {'neither' if mass is None else 'both'}",
            argument="mass",
        )
    if mass is not None:
        if not isinstance(mass, list | tuple) and np.ndim(mass) == 0:
            masses = np.full(n_points, as_positive_float(mass, "mass") / n_points)  # type: ignore[arg-type]
            return _require_heavy(masses, "mass")
        masses = as_column(mass, "mass", n_points, "point")
        require_each(masses > 0.0, "mass", "be positive", masses, "point")
        return _require_heavy(masses, "mass")
    if mesh is None:
        raise ArgumentError("area_density needs a mesh, whose faces have areas", argument="area_density")
    density = as_positive_float(area_density, "area_density")  # type: ignore[arg-type]  # one of the two is given
    masses = density * share_areas(mesh)
    require_each(masses > 0.0, "area_density", "give every point a mass", masses, "point")
    return _require_heavy(masses, "area_density")


def _require_heavy(masses: Float64Array, name: str) -> Float64Array:
    """Return the mass of each point; raise ArgumentError for one of which float32 does not hold the inverse."""
    require_each(masses >= MIN_MASS_KG, name, f"give every point at least {MIN_MASS_KG:g} kg", masses, "point")
    return masses


def _as_mask(pinned: npt.ArrayLike, n_points: int) -> BoolArray:
    """Return which points are pinned (n,)."""
    mask = np.zeros(n_points, np.bool_)
    mask[as_point_indices(pinned, "pinned", n_points)] = True
    return mask
