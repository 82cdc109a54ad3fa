"""Results that grow beside their destination: locked, resumed, and renamed when they are whole."""

import json
import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from .._core.file_locks import describe_process, is_at, refuse_second_run, try_lock
from .._core.targets import put_in_place
from .._core.types import StrPath
from ..errors import ArgumentError
from .protocol import Encoded, OtherWorkError

WRITE_BYTES = 1 << 20  # Linux takes half the time for large writes that come in pieces
SEND_BYTES = 16 << 20  # that lie in memory before the system begins to send them to the disk


class FileSink:
    """The part of a sink that all files have in common: a header, the parts in order, and what is patched at the end.

    A subclass sets `head`, the bytes before the first part, and may override `finish`, which `is_patched` tells of.
    Where parts have `facts` or no common size, a journal beside the file says how far it is whole.
    """

    head: bytes = b""
    point_bytes: int = 0
    is_patched = False
    has_journal = False
    is_parallel = False
    keeps_raw = False

    def __init__(self, destination: StrPath, path: Path, is_stream: bool) -> None:
        self._destination = os.fspath(destination)
        self._path = path
        self.is_stream = is_stream
        self._n_points = 0
        self._n_unsent = 0
        self._facts: list[dict[str, Any]] = []
        self._file: BinaryIO

    def __getstate__(self) -> dict[str, Any]:
        """Leave the open file out: elsewhere parts are encoded, and none is written."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_file", "_facts")}

    def open(self, resume: bool, step: int, work: str) -> AbstractContextManager[int]:
        """Open the file, lend how many points its whole parts hold, and finish it at the end of the block."""
        return self._open_stream() if self.is_stream else self._open_partial(resume, step, work)

    def append(self, part: Encoded) -> None:
        """Write a part, and hand it to the system."""
        with self.name_destination():
            body = memoryview(part.body).cast("B")
            for start in range(0, len(body), WRITE_BYTES):
                self._file.write(body[start : start + WRITE_BYTES])
            self._file.flush()
            self._send(len(body))
            self._facts.append(part.facts)
            self._n_points += part.n_points
            if self.has_journal:
                line = json.dumps({"points": self._n_points, "end": self._file.tell(), "facts": part.facts})
                with self._note.open("a", encoding="utf-8") as note:
                    note.write(line + "\n")

    def _send(self, n_bytes: int) -> None:
        """Let the system begin to send what was written to the disk: at the end `fsync` waits for the rest alone.

        Linux takes the advice as that; what is not yet on the disk stays in memory, for whoever reads the result.
        """
        self._n_unsent += n_bytes
        if self.is_stream or self._n_unsent < SEND_BYTES or not hasattr(os, "posix_fadvise"):
            return
        with suppress(OSError):  # of file systems that take no advice
            start = self._file.tell() - self._n_unsent
            os.posix_fadvise(self._file.fileno(), start, self._n_unsent, os.POSIX_FADV_DONTNEED)
        self._n_unsent = 0

    def record(self, part: Encoded) -> None:
        """Raise: a file is written by one process."""
        raise NotImplementedError

    def finish(self, file: BinaryIO, facts: list[dict[str, Any]]) -> None:
        """Complete the file, which is at its end; `facts` are those of all parts."""

    def name_destination(self) -> AbstractContextManager[None]:
        """Name the destination in what the system refuses."""
        return name_in_refusals(self._destination)

    @contextmanager
    def _open_stream(self) -> Iterator[int]:
        if self.is_patched:
            raise ArgumentError.expecting("destination", "be a file for this type", repr(self._destination))
        with self._path.open("wb") as self._file:
            with self.name_destination():
                self._file.write(self.head)
                self._file.flush()
            yield 0
            with self.name_destination():
                self.finish(self._file, self._facts)

    @property
    def _partial(self) -> Path:
        return self._path.with_name(self._path.name + ".partial")

    @property
    def _note(self) -> Path:
        return self._path.with_name(self._path.name + ".partial.work")

    @contextmanager
    def _open_partial(self, resume: bool, step: int, work: str) -> Iterator[int]:
        """Open and lock the file beside its destination.

        If the block raises, the file stays if it holds at least one part.
        """
        with name_in_refusals(str(self._partial) if self._partial.is_dir() else self._destination):
            self._file = self._open_locked()
        with self._close_named():
            held = os.fstat(self._file.fileno()).st_size
            before, _, journal = read_note(self._note)
            if resume and (held or before) and before != work:
                if not held:  # it was renamed, and its process killed; if it was its own source, it is not done again
                    self._partial.unlink()
                raise OtherWorkError.of(self._partial)
            try:
                with self.name_destination():
                    if not resume:
                        self._file.truncate(0)
                        journal = []
                    self._keep_whole_parts(step, journal, work)
                yield self._n_points
                with self.name_destination():
                    self.finish(self._file, self._facts)
                    self._file.flush()
                    os.fsync(self._file.fileno())
                    if sys.platform == "win32":  # where no open file is renamed
                        self._file.close()
                    put_in_place(self._partial, self._path)
                    self._note.unlink(missing_ok=True)
            except BaseException:
                if self._n_points == 0:
                    self._partial.unlink(missing_ok=True)
                    self._note.unlink(missing_ok=True)
                raise

    @contextmanager
    def _close_named(self) -> Iterator[None]:
        """Close the file at the end of the block: what a full disk has not taken is tried again then."""
        try:
            yield
        finally:
            with self.name_destination():
                self._file.close()

    def _open_locked(self) -> BinaryIO:
        """Open the unfinished file, or make it; raise `ArgumentError` if another run holds it."""
        while True:
            file = os.fdopen(os.open(self._partial, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b")
            if not try_lock(file):
                file.close()
                raise refuse_second_run("destination", self._destination, read_note(self._note)[1])
            if is_at(file, self._partial):
                return file
            file.close()  # another run has finished meanwhile

    def _keep_whole_parts(self, step: int, journal: list[dict[str, Any]], work: str) -> None:
        """Write the head, cut off what is not a whole part, and count the points that are kept."""
        file = self._file
        held = os.fstat(file.fileno()).st_size
        kept = [line for line in journal if line["end"] <= held]
        write_note(self._note, work, kept)
        file.seek(0)
        file.write(self.head)
        file.flush()
        if self.has_journal:
            end, self._n_points = (kept[-1]["end"], kept[-1]["points"]) if kept else (len(self.head), 0)
            self._facts = [line["facts"] for line in kept]
        else:
            n_held = max(held - len(self.head), 0) // self.point_bytes
            self._n_points = n_held - n_held % step
            end = len(self.head) + self._n_points * self.point_bytes
        file.seek(end)
        file.truncate()


@contextmanager
def name_in_refusals(destination: str) -> Iterator[None]:
    """Name a destination in what the system refuses: Python does not say which file a full disk is about."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, destination) from None


def write_note(note: Path, work: str, journal: list[dict[str, Any]]) -> None:
    """Write whom an unfinished result belongs to, and how far it is whole."""
    lines = [work, describe_process(), *map(json.dumps, journal)]
    note.write_text("\n".join(lines) + "\n", "utf-8")


def read_note(note: Path) -> tuple[str, str, list[dict[str, Any]]]:
    """Return which work an unfinished result belongs to, who is at it or was, and the whole lines of its journal."""
    try:
        work, holder, *lines = note.read_text("utf-8").split("\n")
    except (OSError, ValueError):
        return "", "", []
    journal = []
    for line in lines:
        try:
            journal.append(json.loads(line))
        except ValueError:  # the last one, of a process that was killed
            break
    return work, holder.strip(), journal
