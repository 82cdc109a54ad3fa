"""Limits of what a model file may hold, and the budget of what it may expand to, counted before it is allocated."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from .._core.public import public
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from ._text import quote

# What a file may expand to, by USE, components, instances and shared arrays, without a limit of the caller's: so much
# in any case, and so much more per byte or node that it holds itself.
FREE_NUMBERS, NUMBERS_PER_BYTE = 1 << 22, 4
NUMBERS_PER_POINT = 16  # coordinates, its share of indices, and attributes
FREE_NODES, NODES_PER_NODE = 1 << 13, 8
FREE_BYTES = 1 << 20
# How dense words and nodes may be in a text, as each takes time to parse: what holds data has longer ones.
FREE_PARTS, BYTES_PER_PART = 1 << 16, 4
FREE_SPELLED_NODES, BYTES_PER_NODE, PARTS_PER_NODE = 1 << 13, 16, 16
# How dense elements and attributes may be in XML, by the bytes that it is compressed to: the most regular meshes, grids
# and voxels, have 3.9 bytes per vertex or triangle.
FREE_ELEMENTS, BYTES_PER_ELEMENT, ATTRIBUTES_PER_ELEMENT = 1 << 16, 3, 8
# How small chunks may be that are decompressed one by one, as each takes time however little it holds.
FREE_CHUNKS, BYTES_PER_CHUNK = 1 << 11, 1 << 10


@public
@dataclass(frozen=True, kw_only=True)
class FileLimits:
    """What a model file may hold; what exceeds a limit is a `MeshError` that names it.

    By default each is None: a file may hold what its bytes spell out, and expand to 4 million numbers, 16 per point,
    and to 4 more per byte.

    Parameters
    ----------
    points, faces : int, optional
        Points, and faces, in all that the file shows.
    face_corners : int, optional
        Corners of one face.
    nodes : int, optional
        Nodes, each counted as often as it is shown; chunks of LAZ.
    depth : int, optional
        Nodes within one another.
    unpacked_bytes : int, optional
        Bytes that compressed content unpacks to, and that files beside the file have which are read with it: `.mtl` of
        OBJ, buffers and images of glTF, the models of URDF, what VRML includes.
    cpu_s : float, optional
        Seconds that a processor may work on it; with `isolated=True`, where it is 60 by default, and for the process
        in which Open CASCADE reads a STEP file, 600 and another 600 per megabyte by default. They count from when the
        reader begins, the libraries that it needs loaded, so however few they are, they are kept; where the process
        works without a processor, it is ended after twice as many by the clock, and 30 s more.
    memory_bytes : int, optional
        Bytes of memory that reading it may take; with `isolated=True`, where it is 4 GiB by default, and for that
        process, 4 GiB and another 4 KiB per byte by default. They count from when the reader begins, too: what the
        process takes from the system beyond what it has then.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        For a limit that is no positive number.
    """

    points: int | None = None
    faces: int | None = None
    face_corners: int | None = None
    nodes: int | None = None
    depth: int | None = None
    unpacked_bytes: int | None = None
    cpu_s: float | None = None
    memory_bytes: int | None = None

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if value is None:
                continue
            is_whole = each.name != "cpu_s"
            expected = f"be a positive {'whole ' * is_whole}number"
            try:
                number = operator.index(value) if is_whole else float(value)
            except OverflowError:
                number = float("inf")
            except (TypeError, ValueError):
                raise ArgumentTypeError.expecting(each.name, expected, repr(value)) from None
            if isinstance(value, bool) or not 0 < number < float("inf"):
                raise ArgumentError.expecting(each.name, expected, repr(value))
            object.__setattr__(self, each.name, number)


NO_LIMITS = FileLimits()


class Budget:
    """What a file may still expand to."""

    def __init__(self, n_bytes: int = 0, limits: FileLimits = NO_LIMITS) -> None:
        self.limits = limits
        self._n_bytes = n_bytes
        self._numbers = 0
        self._values = 0
        self._nodes = 0
        self._spelled_nodes = 0
        self._elements = 0
        self._unpacked = 0
        self.is_spent = False  # which an error has said
        self._most_numbers = self._most_nodes = 0
        self._set_most()

    def allow_bytes(self, n_bytes: int) -> None:
        """Note that the file holds more bytes than at first: in files beside it, or when it is unpacked."""
        self._n_bytes += n_bytes
        self._set_most()

    def spell_nodes(self, n_nodes: int) -> None:
        """Note that the file spells out so many nodes."""
        self._spelled_nodes += n_nodes
        self._set_most()

    def _set_most(self) -> None:
        points, nodes = self.limits.points, self.limits.nodes
        self._most_numbers = (
            FREE_NUMBERS + NUMBERS_PER_BYTE * self._n_bytes if points is None else NUMBERS_PER_POINT * points
        )
        self._most_nodes = FREE_NODES + NODES_PER_NODE * self._spelled_nodes if nodes is None else nodes

    def require_parts(self, n_parts: int, n_nodes: int) -> None:
        """Raise MeshError for a text of more words, or nodes, than one of its size has that holds data."""
        limit = self.limits.nodes
        for count, free, n_bytes, what in (
            (n_nodes, FREE_SPELLED_NODES, BYTES_PER_NODE, "nodes"),
            (n_parts, FREE_PARTS, BYTES_PER_PART, "words"),
        ):
            most, allowed = free + self._n_bytes // n_bytes, PARTS_PER_NODE * (limit or 0)
            if count > max(most, allowed):
                bound = f"{most:,}, the limit {_name('nodes', None)}"
                if allowed > most:
                    bound = f"{PARTS_PER_NODE} for each of the nodes that {_name('nodes', limit)} allows"
                raise MeshError(f"it is made of {count:,} {what}, more than {bound}")

    def take_elements(self, n_elements: int, n_attributes: int) -> None:
        """Count elements of compressed XML; raise MeshError for more than a file of its size has that holds data."""
        self._elements += max(n_elements, n_attributes // ATTRIBUTES_PER_ELEMENT)
        limit = self.limits.nodes
        most = max(FREE_ELEMENTS + self._n_bytes // BYTES_PER_ELEMENT, PARTS_PER_NODE * (limit or 0))
        if self._elements > most:
            raise MeshError(
                f"it is made of more than {most:,} elements of {ATTRIBUTES_PER_ELEMENT} attributes, "
                f"the limit {_name('nodes', limit)}"
            )

    def require_chunks(self, n_chunks: int) -> None:
        """Raise MeshError for more compressed chunks than a file of its size has that holds data."""
        limit = self.limits.nodes
        most = FREE_CHUNKS + self._n_bytes // BYTES_PER_CHUNK if limit is None else limit
        if n_chunks > most:
            raise MeshError(
                f"it is made of {n_chunks:,} compressed chunks, more than {most:,}, the limit {_name('nodes', limit)}"
            )

    def take_numbers(self, n_numbers: int, where: str | int) -> None:
        """Count coordinates and indices that are about to be allocated; raise MeshError if they are too many.

        where : a place in the file, or a line
        """
        self._numbers += n_numbers
        if self._numbers > self._most_numbers:
            self.is_spent = True
            place, name = _describe_place(where), _name("points", self.limits.points)
            most = f"{self._most_numbers // NUMBERS_PER_POINT:,} points of {NUMBERS_PER_POINT} numbers"
            raise MeshError(f"{place}: expands to more than {most}, the limit {name}")

    def take_nodes(self, n_nodes: int, where: str | int) -> None:
        """Count nodes that are shown; raise MeshError if they are too many. `where` is as of `take_numbers`."""
        self._nodes += n_nodes
        if self._nodes > self._most_nodes:
            self.is_spent = True
            place, name = _describe_place(where), _name("nodes", self.limits.nodes)
            raise MeshError(f"{place}: expands to more than {self._most_nodes:,} nodes, the limit {name}")

    def take_values(self, n_values: int, where: str) -> None:
        """Count numbers that are about to be allocated beside those of points: matrices and keyframes; or raise."""
        self._values += n_values
        points = self.limits.points
        most = max(FREE_NUMBERS + NUMBERS_PER_BYTE * self._n_bytes, NUMBERS_PER_POINT * (points or 0))
        if self._values > most:
            self.is_spent = True
            name = _name("points", points)
            raise MeshError(f"{where}: expands to more than {most:,} numbers beside its points, the limit {name}")

    def taken(self) -> tuple[int, int]:
        """Return how many nodes and numbers were counted so far."""
        return self._nodes, self._numbers

    def has_room(self, n_nodes: int, n_numbers: int) -> bool:
        """Tell whether so many nodes and numbers may still be counted."""
        return self._nodes + n_nodes <= self._most_nodes and self._numbers + n_numbers <= self._most_numbers

    def take_bytes(self, n_bytes: int, ratio: int, where: str) -> None:
        """Count bytes that will be unpacked; raise MeshError if they are more than `ratio` per byte of the file."""
        self._unpacked += n_bytes
        limit = self.limits.unpacked_bytes
        most = self.most_bytes(ratio)
        if self._unpacked > most:
            raise MeshError(
                f"{where}: unpacks to more than the {most:,} bytes that are allowed, "
                f"the limit {_name('unpacked_bytes', limit)}"
            )

    def read_beside(self, path: Path) -> bytes:
        """Return the content of a file that the file names; raise MeshError, unread, if the caller allows less."""
        if self.limits.unpacked_bytes is not None:
            self.take_bytes(path.stat().st_size, 0, quote(path.name))
        data = path.read_bytes()
        self.allow_bytes(len(data))
        return data

    def most_bytes(self, ratio: int) -> int:
        """Return how many bytes may be unpacked in all."""
        limit = self.limits.unpacked_bytes
        return FREE_BYTES + ratio * self._n_bytes if limit is None else limit

    def require_depth(self, depth: int, default: int | None = None) -> None:
        """Raise MeshError for nodes too deep within one another."""
        limit = self.limits.depth
        most = default if limit is None else limit
        if most is not None and depth > most:
            raise MeshError(f"its nodes are more than {most:,} deep, the limit {_name('depth', limit)}")

    def require_mesh(self, meshes: list[Mesh]) -> None:
        """Raise MeshError for meshes that hold more than the caller allows."""
        limits = self.limits
        n_corners = max((int(np.diff(mesh.offsets).max(initial=0)) for mesh in meshes), default=0)
        for name, count in (
            ("points", sum(mesh.n_points for mesh in meshes)),
            ("faces", sum(mesh.n_faces for mesh in meshes)),
            ("face_corners", n_corners),
        ):
            limit = getattr(limits, name)
            if limit is not None and count > limit:
                what = "a face of it has" if name == "face_corners" else "it has"
                word = "corners" if name == "face_corners" else name
                raise MeshError(f"{what} {count:,} {word}, more than FileLimits({name}={limit}) allows")


_default: ContextVar[FileLimits] = ContextVar("_default", default=NO_LIMITS)
_default_isolated: ContextVar[bool] = ContextVar("_default_isolated", default=False)
_current: ContextVar[Budget | None] = ContextVar("_current", default=None)


def budget() -> Budget:
    """Return the budget of the file that is being read."""
    return _current.get() or Budget(FREE_BYTES)


@contextmanager
def spend_own(n_bytes: int) -> Iterator[None]:
    """Give a file of so many bytes a budget, unless the block is within that of its own."""
    if _current.get() is not None:
        yield
        return
    with spend(n_bytes, NO_LIMITS):
        yield


@contextmanager
def use_limits(limits: FileLimits, *, isolated: bool) -> Iterator[None]:
    """Let files that are read in the block without limits of their own have these, and be read in isolation."""
    token, isolated_token = _default.set(limits), _default_isolated.set(isolated)
    try:
        yield
    finally:
        _default.reset(token)
        _default_isolated.reset(isolated_token)


def is_isolated() -> bool:
    """Return whether files are read in isolation by default."""
    return _default_isolated.get()


def as_limits(limits: FileLimits | None) -> FileLimits:
    """Return the limits, or by default those of the block; raise `ArgumentTypeError` for anything else."""
    if limits is not None and not isinstance(limits, FileLimits):
        raise ArgumentTypeError.expecting("limits", "be FileLimits", repr(limits))
    return _default.get() if limits is None else limits


@contextmanager
def spend(n_bytes: int, limits: FileLimits) -> Iterator[Budget]:
    """Let what is read in the block have the budget of a file of so many bytes."""
    token = _current.set(Budget(n_bytes, limits))
    try:
        yield budget()
    finally:
        _current.reset(token)


def _describe_place(where: str | int) -> str:
    return f"line {where}" if isinstance(where, int) else where


def _name(name: str, limit: int | None) -> str:
    return f"FileLimits({name}=...)" if limit is None else f"FileLimits({name}={limit})"
