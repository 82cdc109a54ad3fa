"""Child strands: many strands for a picture, interpolated on the device between a few that are simulated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_int
from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..device import Device
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.mesh import Mesh, move
from ..geometry.strands import Strands
from ..gpu.chunking import choose_workgroup_size
from ..gpu.device import resolve_gpu_device
from ..gpu.dispatch import Binding, dispatch
from ._validation import as_points

POOL_OWNER = "child strands"
N_NEIGHBORS = 6  # of a guide, among which two more are chosen
ROWS_PER_BLOCK = 1024  # of the table of distances between roots


@public
class ChildStrands:
    """Strands interpolated between guides: hair of which only a part is simulated.

    Each child starts at a random place between the roots of three guides that are neighbours, and follows them with
    weights that sum to 1. What moves the roots of the guides so moves those of the children.

    Parameters
    ----------
    guides : Strands
        At least 3, as they are at the start.
    n : int
        The number of children.
    clump : float
        How much of the way to its nearest guide the tip of a child is, from 0 to 1; other points less, by the square of
        their distance along the strand.
    min_length : float
        The length of the shortest children as a part of the guides', from 0 to 1; lengths are spread evenly above it.
    seed : int
        Of the random choices.
    device : Device, optional
        By default the process's own.

    Raises
    ------
    ArgumentError
        "guides must be at least 3, got 2", or for a number out of range.
    """

    def __init__(
        self,
        guides: Strands,
        n: int,
        *,
        clump: float = 0.3,
        min_length: float = 0.8,
        seed: int = 0,
        device: Device | None = None,
    ) -> None:
        if not isinstance(guides, Strands):
            raise ArgumentTypeError.expecting("guides", "be Strands", type(guides).__name__)
        if guides.n_strands < 3:
            raise ArgumentError.expecting("guides", "be at least 3", guides.n_strands)
        self._device = resolve_gpu_device(device)
        self._n_points = guides.n_points
        limits = self._device.limits
        room = min(limits.max_workgroups * choose_workgroup_size(self._device), limits.max_bound_bytes // 12)
        n = as_int(n, "n")
        if not 1 <= n <= room // guides.n_points:
            raise ArgumentError.expecting("n", f"lie in 1..{room // guides.n_points}", n)
        clump, min_length = _as_part(clump, "clump"), _as_part(min_length, "min_length")
        seed = as_int(seed, "seed")
        if seed < 0:
            raise ArgumentError.expecting("seed", "not be negative", seed)
        rng = np.random.default_rng(seed)
        self._guides = _choose_guides(guides.points[:, 0], n, rng)
        self._weights = _choose_weights(n, rng)
        self._lengths = rng.uniform(min_length, 1.0, n).astype(np.float32)
        self._packed = np.zeros((n, 2, 4), np.uint32)
        self._packed[:, 0, :3] = self._guides
        self._packed[:, 0, 3] = self._lengths.view(np.uint32)
        self._packed[:, 1, :2] = self._weights[:, :2].view(np.uint32)
        self._packed[:, 1, 2] = np.full(n, clump, np.float32).view(np.uint32)
        self._n_guide_points = guides.n_strands * guides.n_points
        index = np.arange(n * guides.n_points).reshape(n, guides.n_points)
        segments = np.stack([index[:, :-1], index[:, 1:]], axis=-1).reshape(-1, 2)
        self._mesh = Mesh(np.zeros((n * guides.n_points, 3)), segments)
        self._mesh = self._at(guides.points.reshape(-1, 3))

    @property
    def n_strands(self) -> int:
        """The number of children."""
        return len(self._guides)

    @property
    def mesh(self) -> Mesh:
        """The children at the start, as segments."""
        return self._mesh

    @property
    def guides(self) -> IndexArray:
        """The three guides of each child, that with the largest weight first: (n, 3) int64."""
        return self._guides.copy()

    @property
    def weights(self) -> npt.NDArray[np.float32]:
        """The weights of the three guides at the root of each child: (n, 3) float32."""
        return self._weights.copy()

    @property
    def lengths(self) -> npt.NDArray[np.float32]:
        """The length of each child as a part of the guides': (n,) float32."""
        return self._lengths.copy()

    def interpolate(self, positions: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """Return where the children are for given positions of the guides.

        Point k of a child is the sum over its guides of their weights times their points at k times the child's length,
        linear between two of them. From `weights` at the root, weights go clump (k/(p - 1))^2 of the way to (1, 0, 0).

        Parameters
        ----------
        positions : (s p, 3) numbers
            As `Springs.positions`, or a frame of a `Trajectory`.

        Returns
        -------
        (n p, 3) float32
            Strand by strand, as in `mesh`.

        Raises
        ------
        ArgumentError
            "positions must have shape (s p, 3), got ...".
        """
        points = as_points(positions, "positions", self._n_guide_points)
        packed = np.zeros((len(points), 4), np.float32)
        packed[:, :3] = points
        n_out = self.n_strands * self._n_points
        device = self._device
        size = choose_workgroup_size(device)
        with device.lock:
            sources = [
                device.pool.scratch(POOL_OWNER, key, array.nbytes)
                for key, array in (("children", self._packed), ("guides", packed))
            ]
            for buffer, array in zip(sources, (self._packed, packed), strict=True):
                buffer.upload(array)
            result = device.pool.scratch(POOL_OWNER, "points", 12 * n_out)
            pipeline = device.pipelines.compute("interpolate_strands", workgroup_size=size, n_points=self._n_points)
            with device.encode_commands(*sources, result, label="child strands") as encoder:
                children = Binding(sources[0], 0, self._packed.nbytes)  # its length tells how many there are
                bindings = device.bind_groups.bind(pipeline, children=children, guides=sources[1], points=result)
                dispatch(encoder, pipeline, bindings, -(-n_out // size))
            with result.map_read(12 * n_out) as view:
                return view.view(np.float32).reshape(-1, 3).copy()

    def meshes(self, frames: Sequence[npt.NDArray[np.float32]]) -> Sequence[Mesh]:
        """Return the children in each frame, made when it is requested, for `animate`.

        Parameters
        ----------
        frames : Trajectory, or a sequence of (s p, 3) numbers
            The positions of the guides.

        Returns
        -------
        sequence of Mesh
        """
        return _Meshes(self, frames)

    def _at(self, positions: npt.ArrayLike) -> Mesh:
        return move(self._mesh, self.interpolate(positions), np.eye(4))

    def __repr__(self) -> str:
        return f"<ChildStrands: {self.n_strands} of {self._n_points} points>"


class _Meshes(Sequence[Mesh]):
    """A mesh per frame, none of which is kept."""

    def __init__(self, children: ChildStrands, frames: Sequence[npt.NDArray[np.float32]]) -> None:
        self._children = children
        self._frames = frames

    @overload
    def __getitem__(self, frame: int) -> Mesh: ...
    @overload
    def __getitem__(self, frame: slice) -> _Meshes: ...
    def __getitem__(self, frame: int | slice) -> Mesh | _Meshes:
        if isinstance(frame, slice):
            return _Meshes(self._children, self._frames[frame])
        return self._children._at(self._frames[frame])

    def __len__(self) -> int:
        return len(self._frames)


def _as_part(value: float, name: str) -> float:
    """Return `value` as a float from 0 to 1."""
    part = as_float(value, name)
    if not 0.0 <= part <= 1.0:
        raise ArgumentError.expecting(name, "lie in 0..1", f"{part:g}")
    return part


def _choose_guides(roots: Float64Array, n: int, rng: np.random.Generator) -> IndexArray:
    """Return three guides with neighbouring roots (n, 3) for each child; each guide is first for as many children."""
    first = np.arange(n) % len(roots)
    neighbors = _find_neighbors(roots)
    second = neighbors[first, rng.integers(neighbors.shape[1], size=n)]
    # The third is the neighbour of the first that is nearest to the second, so that the three are no long triangle.
    others = neighbors[first]
    distances = np.linalg.norm(roots[others] - roots[second][:, np.newaxis], axis=2)
    distances[others == second[:, np.newaxis]] = np.inf
    third = others[np.arange(n), np.argmin(distances, axis=1)]
    return np.stack([first, second, third], axis=1)


def _find_neighbors(roots: Float64Array) -> IndexArray:
    """Return for each root the nearest others (s, k), k at most N_NEIGHBORS."""
    k = min(N_NEIGHBORS, len(roots) - 1)
    blocks = []
    for start in range(0, len(roots), ROWS_PER_BLOCK):
        block = roots[start : start + ROWS_PER_BLOCK]
        squares = ((block[:, np.newaxis] - roots[np.newaxis]) ** 2).sum(axis=2)
        squares[np.arange(len(block)), start + np.arange(len(block))] = np.inf
        blocks.append(np.argsort(squares, axis=1, kind="stable")[:, :k])
    return np.concatenate(blocks)


def _choose_weights(n: int, rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Return barycentric weights (n, 3), evenly spread over a triangle, the largest first."""
    weights = np.sort(rng.dirichlet((1.0, 1.0, 1.0), n), axis=1)[:, ::-1].astype(np.float32)
    weights[:, 2] = np.float32(1.0) - weights[:, 0] - weights[:, 1]
    return weights
