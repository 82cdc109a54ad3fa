"""Zarr arrays of points in a folder, format 2 or 3 to read, 3 with shards to write, as chunked points.

A shard is the least that may be written at a time: parts are whole shards, so that no two writers meet in one.
"""

import errno
import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.file_locks import is_at, refuse_second_run, try_lock
from .._core.interrupts import defer_interrupts
from .._core.targets import require_path
from .._core.types import StrPath
from ..errors import ArgumentError, ArgumentTypeError, MissingExtraError
from .npy import scan_bounds
from .partial_files import name_in_refusals, read_note, write_note
from .protocol import Block, Bounds, ChunkError, Directions, Encoded, OtherWorkError, PointSource

SHARD_POINTS = 1 << 20
LARGE_SHARD_POINTS = 1 << 24  # a graph of 1e12 points in blocks of a million would have a million tasks
MANY_POINTS = 1 << 33
CHUNKS_PER_SHARD = 4
WRITE_ALL = {"write_empty_chunks": True}  # to look for chunks of zeros takes a quarter of the time to write
_METADATA = ("zarr.json", ".zarray")
_MAX_NAMED = 8
_MAX_CHUNK_BYTES = 1 << 31  # what codecs take
_FREE_CHUNK_BYTES = 1 << 26  # of an array that will grow, and has fewer points than a chunk


def import_zarr() -> Any:
    """Return zarr; raise MissingExtraError without it."""
    try:
        with defer_interrupts():
            import zarr
    except ImportError:
        raise MissingExtraError("Zarr needs zarr: pip install 'gpu_xform[zarr]'") from None
    return zarr


def open_array(path: StrPath) -> Any:
    """Return the array at a path, to read."""
    zarr = import_zarr()
    if not Path(path).exists():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fspath(path))
    try:
        return zarr.open_array(os.fspath(path), mode="r")
    except Exception as error:
        if isinstance(error, OSError) and error.errno is not None:  # zarr says that there is no array by one without
            raise
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        if names := _list_arrays(path):
            text = f"it is a group; name one of its arrays: {', '.join(names)}"
        raise ArgumentError.expecting("source", "be a Zarr array", repr(os.fspath(path)), reason=text) from None


def _list_arrays(path: StrPath) -> list[str]:
    """Return the paths of the first arrays in a group; none if it is no group."""
    folders = [metadata.parent for name in _METADATA for metadata in Path(path).glob(f"*/{name}")]
    return sorted(str(folder) for folder in folders if _is_array(folder))[:_MAX_NAMED]


def _is_array(folder: Path) -> bool:
    """Return whether a folder is a Zarr array, and not a group of several."""
    if (folder / ".zarray").is_file():
        return True
    try:
        content = json.loads((folder / "zarr.json").read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and content.get("node_type") == "array"


def read_attributes(array: Any) -> dict[str, Any]:
    """Return the attributes of an array; none where its metadata have something else there."""
    found = array.metadata.attributes
    return dict(found) if isinstance(found, Mapping) else {}


def stored_rows(array: Any) -> int:
    """Return how many rows are stored together: a shard's, where there are shards."""
    return int((array.shards or array.chunks)[0])


class ZarrSource:
    """A Zarr array (n, 3) or (n, 2) of float32 or float64."""

    file_type = "zarr"
    attributes: Sequence[str] = ()
    directions: Sequence[Directions] = ()

    def __init__(self, path: StrPath) -> None:
        self.path = os.fspath(path)
        self.array = open_array(path)
        self.dtype = np.dtype(self.array.dtype)
        if self.dtype.kind != "f" or self.dtype.itemsize not in {4, 8}:
            raise ArgumentTypeError.expecting("source", "hold float32 or float64", f"{self.dtype} in {self.path!r}")
        shape = self.array.shape
        if len(shape) != 2 or shape[1] not in {2, 3}:
            raise ArgumentError.expecting("source", "have shape (n, 3) or (n, 2)", f"{shape} in {self.path!r}")
        self.n_points, self.n_columns = shape
        self.point_bytes = self.n_columns * self.dtype.itemsize
        if min(*self.array.chunks, *(self.array.shards or ())) < 1:
            raise ArgumentError.expecting("source", "have chunks of points", f"{self.array.chunks} in {self.path!r}")
        self.chunk_points = stored_rows(self.array)
        n_bytes = self.point_bytes * self.array.chunks[0]
        most = min(max(_FREE_CHUNK_BYTES, 2 * self.point_bytes * self.n_points), _MAX_CHUNK_BYTES)
        if n_bytes > most:  # which are allocated, whatever is stored
            expected = f"have chunks of at most {most:,} bytes, for {self.n_points:,} points"
            raise ArgumentError.expecting("source", expected, f"{n_bytes:,} in {self.path!r}")
        self.world_from_stored = np.identity(self.n_columns + 1)

    def read(self, start: int, stop: int) -> Block:
        """Return the points from `start` up to `stop`; raise ChunkError with the first that cannot be read."""
        try:
            return Block(start, self.array[start:stop])
        except Exception:
            for begin in range(start - start % self.chunk_points, stop, self.chunk_points):
                end = min(begin + self.chunk_points, self.n_points)
                try:
                    self.array[begin:end]
                except Exception as error:  # each codec has errors of its own
                    text = " ".join(str(error).split())
                    raise ChunkError(
                        f"{self.path}: chunk {self._key(begin)} (points {begin} to {end - 1}) cannot be read: {text}",
                        *(begin, end),
                    ) from None
            raise

    def _key(self, start: int) -> str:
        return str(self.array.metadata.encode_chunk_key((start // self.chunk_points, 0)))

    def read_raw(self, start: int, stop: int) -> Block:
        """Return a chunk or shard as it is stored."""
        key = self._key(start)
        data = (Path(self.path) / key).read_bytes()
        return Block(start, np.empty((0, self.n_columns)), None, (stop - start, (key, data)))

    def read_bounds(self) -> Bounds:
        """Return the corners of the box of all points, which are read for it."""
        return scan_bounds(self)

    def read_columns(self, block: Block) -> Mapping[str, npt.NDArray[Any]]:  # noqa: ARG002
        """Return nothing: there are positions alone."""
        return {}

    def describe_state(self) -> list[Any]:
        """Return shape, type and time of the array."""
        folder = Path(self.path)
        times = [(folder / name).stat().st_mtime_ns for name in _METADATA if (folder / name).exists()]
        newest = max((entry.stat().st_mtime_ns for entry in folder.iterdir()), default=0)
        return [list(self.array.shape), self.dtype.str, times, newest]

    def close(self) -> None:
        """Do nothing: files are open while they are read."""


class ZarrSink:
    """A Zarr array that grows in a folder beside its destination, in shards that any process may write."""

    is_parallel = True
    keeps_raw = True
    is_stream = False

    def __init__(self, destination: StrPath, shape: tuple[int, int], dtype: np.dtype[Any], source: Any) -> None:
        """Take the shards, codecs and attributes of `source`, a Zarr array, if it is one whose rows are whole."""
        self._destination = os.fspath(destination)
        self._path = find_zarr_target(destination)
        self._shape, self._dtype = shape, dtype.newbyteorder("=")
        self._layout = _copy_layout(source, shape) or choose_layout(shape)
        self._keeps_layout = _copy_layout(source, shape) is not None
        self.chunk_points = (self._layout.get("shards") or self._layout["chunks"])[0]
        self.world_from_stored = np.identity(shape[1] + 1)
        self._n_points = 0
        self._work = ""
        self._array: Any = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_array": None, "_work": ""}  # elsewhere nothing is noted

    @property
    def _partial(self) -> Path:
        return self._path.with_name(self._path.name + ".partial")

    @property
    def _note(self) -> Path:
        return self._path.with_name(self._path.name + ".partial.work")

    def encode(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> Encoded:
        """Return positions in the type of the array."""
        if block.raw is not None:
            if not self._keeps_layout or source.file_type != "zarr":
                raise ArgumentError(
                    f"{self._destination}: cannot hold a chunk that cannot be read, from another layout"
                )
            return Encoded(block.start, block.raw[0], block.raw[1])
        return Encoded(block.start, len(positions), np.ascontiguousarray(positions, self._dtype))

    @contextmanager
    def open(self, resume: bool, step: int, work: str) -> Iterator[int]:  # noqa: ARG002
        """Make the array or go on with it, and put it at its destination at the end of the block."""
        with self._lock():
            before, _, journal = read_note(self._note)
            if resume and before and before != work:  # without a folder: it was renamed, and its process killed
                raise OtherWorkError.of(self._partial)
            try:
                with name_in_refusals(str(self._partial) if self._partial.is_file() else self._destination):
                    if not (resume and before == work and self._partial.exists()):
                        journal = []
                        if self._partial.exists():
                            shutil.rmtree(self._partial)
                        self._create()
                    write_note(self._note, work, journal)
                self._work = work
                done = {line["start"]: line["points"] for line in journal}
                while self._n_points in done:
                    self._n_points += done[self._n_points]
                yield self._n_points
                self._finish()
            except BaseException:
                if not read_note(self._note)[2]:
                    shutil.rmtree(self._partial, ignore_errors=True)
                    self._note.unlink(missing_ok=True)
                raise

    @contextmanager
    def _lock(self) -> Iterator[None]:
        while True:
            with name_in_refusals(self._destination):
                file: BinaryIO = self._note.open("ab")
            if not try_lock(file):
                file.close()
                raise refuse_second_run("destination", self._destination, read_note(self._note)[1])
            if is_at(file, self._note):
                break
            file.close()
        with file:
            yield

    def _create(self) -> None:
        zarr = import_zarr()
        zarr.create_array(store=str(self._partial), shape=self._shape, dtype=self._dtype, zarr_format=3, **self._layout)

    def append(self, part: Encoded) -> None:
        """Write a part of whole shards, in any process and any order."""
        with name_in_refusals(self._destination):
            if isinstance(part.body, tuple):
                key, data = part.body
                target = self._partial / key
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
            else:
                if self._array is None:
                    self._array = import_zarr().open_array(str(self._partial), mode="r+").with_config(WRITE_ALL)
                self._array[part.start : part.start + part.n_points] = part.body
        if self._work:
            self.record(part)

    def record(self, part: Encoded) -> None:
        """Note a part that is whole."""
        with name_in_refusals(self._destination), self._note.open("a", encoding="utf-8") as note:
            note.write(json.dumps({"start": part.start, "points": part.n_points}) + "\n")

    def _finish(self) -> None:
        for torn in self._partial.rglob("*.partial"):  # which zarr writes beside a chunk, of a process that was killed
            torn.unlink()
        replaced = self._path.with_name(f".{self._path.name}.replaced")
        if replaced.exists():  # of a run that was killed here
            shutil.rmtree(replaced)
        if self._path.exists():
            self._path.rename(replaced)
        self._partial.rename(self._path)
        self._note.unlink(missing_ok=True)
        if replaced.exists():
            shutil.rmtree(replaced)


def choose_layout(shape: tuple[int, int]) -> dict[str, Any]:
    """Return shards and chunks of whole rows: small enough for a worker's memory, few enough for a scheduler."""
    rows = LARGE_SHARD_POINTS if shape[0] > MANY_POINTS else SHARD_POINTS
    return {"shards": (rows, shape[1]), "chunks": (rows // CHUNKS_PER_SHARD, shape[1])}


def _copy_layout(array: Any, shape: tuple[int, int]) -> dict[str, Any] | None:
    """Return shards, chunks, compressors and attributes of a Zarr 3 array whose chunks hold whole rows, else None."""
    if array is None or array.metadata.zarr_format != 3 or array.chunks[1] != shape[1] or array.shape != shape:
        return None
    return {
        "shards": array.shards,
        "chunks": array.chunks,
        "compressors": array.compressors,
        "filters": array.filters,
        "fill_value": array.fill_value,
        "attributes": read_attributes(array),
    }


def find_zarr_target(path: StrPath) -> Path:
    """Return where a Zarr array will be; raise an error where something else stands there."""
    require_path(path, "destination")
    target = Path(os.path.realpath(path))
    if os.path.lexists(target) and not _is_array(target):
        raise ArgumentError.expecting("destination", "be new, or a Zarr array", repr(os.fspath(path)))
    if not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fspath(path))
    return target
