"""Parts that are stored while the next one is made: the same bytes however slow the disk, and nothing told early."""

import os
import threading
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.chunked import las, npy, partial_files, ply
from gpu_xform.chunked.protocol import Encoded
from gpu_xform.chunked.write_behind import WriteBehind
from gpu_xform.compute import streaming
from tests.support.las_files import make_las
from tests.support.reference_transform import AFFINE, some_points

POINTS_PER_PART = 50


class Sink:
    """Keeps what it is given; each part takes a while, and one may fail."""

    chunk_points = 1
    world_from_stored = np.identity(4)
    is_parallel = keeps_raw = False

    def __init__(self, *, is_stream: bool = False, fails_at: int | None = None) -> None:
        self.is_stream, self.fails_at = is_stream, fails_at
        self.starts: list[int] = []
        self.threads: set[str] = set()

    def append(self, part: Encoded) -> None:
        time.sleep(0.005)
        if part.start == self.fails_at:
            raise OSError(28, "No space left on device")
        self.starts.append(part.start)
        self.threads.add(threading.current_thread().name)


def run(sink: Any, n_parts: int) -> list[int]:
    """Give parts to a sink; return what was told as stored."""
    told: list[int] = []

    def tell(part: Encoded) -> None:
        assert sink.starts[-1] == part.start  # all before it, and none after
        told.append(part.start)

    with WriteBehind(sink, tell) as writer:
        for start in range(n_parts):
            writer.take(partial(Encoded, start, 1, b"x"))
    return told


@pytest.mark.parametrize("is_stream", [False, True])
def test_parts_are_stored_and_told_in_their_order(is_stream: bool) -> None:
    sink = Sink(is_stream=is_stream)
    assert run(sink, 5) == sink.starts == [0, 1, 2, 3, 4]
    assert (sink.threads == {threading.current_thread().name}) == is_stream


def test_a_part_is_encoded_while_the_next_one_is_made() -> None:
    begun, made = threading.Event(), threading.Event()

    def encode_late() -> Encoded:
        begun.set()
        assert made.wait(10), "the next part waits for this one"
        return Encoded(0, 1, b"x")

    sink: Any = Sink()
    with WriteBehind(sink, lambda _: None) as writer:
        writer.take(encode_late)
        assert begun.wait(10)
        made.set()
        writer.take(partial(Encoded, 1, 1, b"x"))
    assert sink.starts == [0, 1]


def test_what_goes_wrong_as_a_part_is_encoded_is_raised() -> None:
    def refuse() -> Encoded:
        raise gx.MeshError("coordinates must be finite")

    sink: Any = Sink()

    def encode() -> None:
        with WriteBehind(sink, lambda _: None) as writer:
            writer.take(partial(Encoded, 0, 1, b"x"))
            writer.take(refuse)

    with pytest.raises(gx.MeshError, match="finite"):
        encode()
    assert sink.starts == [0]


@pytest.mark.parametrize("is_stream", [False, True])
@pytest.mark.parametrize("at", [0, 2, 4])
def test_what_goes_wrong_is_raised_and_nothing_follows(at: int, is_stream: bool) -> None:
    sink = Sink(is_stream=is_stream, fails_at=at)
    with pytest.raises(OSError, match="No space"):
        run(sink, 5)
    assert sink.starts == [*range(at)]


def test_a_part_under_way_is_stored_before_another_error_leaves() -> None:
    sink: Any = Sink()

    def interrupt() -> None:
        with WriteBehind(sink, lambda _: None) as writer:
            writer.take(partial(Encoded, 0, 1, b"x"))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupt()
    assert sink.starts == [0]


def _encode_late(encode: Any) -> Any:
    def late(*arguments: Any) -> Any:
        time.sleep(0.01)  # meanwhile the next part is read and transformed
        return encode(*arguments)

    return late


@pytest.mark.parametrize("kind", ["npy", pytest.param("ply", marks=pytest.mark.float64), "las"])
def test_a_slow_disk_gets_the_same_bytes_and_progress_tells_what_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    source, whole, out = (tmp_path / f"{name}.{kind}" for name in ("in", "whole", "out"))
    if kind == "npy":
        np.save(source, some_points(6 * POINTS_PER_PART, np.float32))
    else:
        make_las(tmp_path / "in.las", 6 * POINTS_PER_PART, 3)
    if kind == "ply":  # with other properties, which are stored as they are read
        gx.transform_file(tmp_path / "in.las", source, np.identity(4))
    gx.transform_file(source, whole, AFFINE)  # in one part
    monkeypatch.setattr(streaming, "_choose_step", lambda *_: POINTS_PER_PART)
    append = partial_files.FileSink.append

    def append_late(sink: partial_files.FileSink, part: Encoded) -> None:
        time.sleep(0.01)  # meanwhile the next part is made
        append(sink, part)

    def compare(done: int, total: int) -> None:
        held = out.with_name(out.name + ".partial").stat().st_size
        assert held >= whole.stat().st_size * done / total - head

    head = whole.stat().st_size % POINTS_PER_PART + 600
    monkeypatch.setattr(partial_files.FileSink, "append", append_late)
    for sink in (ply.SamePlySink, las.LasSink, npy.NpySink):
        monkeypatch.setattr(sink, "encode", _encode_late(sink.encode))
    gx.transform_file(source, out, AFFINE, progress=compare)
    assert out.read_bytes() == whole.read_bytes()


def test_a_part_that_cannot_be_encoded_is_named_by_what_was_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = some_points(3 * POINTS_PER_PART, np.float32)
    points[7, 1] = np.nan
    np.save(tmp_path / "in.npy", points)
    monkeypatch.setattr(streaming, "_choose_step", lambda *_: POINTS_PER_PART)
    monkeypatch.setattr(ply.PlySink, "encode", _encode_late(ply.PlySink.encode))
    with pytest.raises(gx.MeshError, match=r"in\.npy: vertex 7: coordinates must be finite"):
        gx.transform_file(tmp_path / "in.npy", tmp_path / "out.ply", AFFINE)
    assert [path.name for path in tmp_path.iterdir()] == ["in.npy"]


@pytest.mark.skipif(not hasattr(os, "posix_fadvise"), reason="the system takes no advice on files")
def test_the_disk_gets_its_bytes_while_parts_are_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[int, int]] = []
    monkeypatch.setattr(partial_files, "SEND_BYTES", 2400)
    monkeypatch.setattr(streaming, "_choose_step", lambda *_: 100)
    monkeypatch.setattr(os, "posix_fadvise", lambda _, start, n_bytes, __: told.append((start, n_bytes)))
    np.save(tmp_path / "in.npy", some_points(550, np.float32))
    gx.transform_file(tmp_path / "in.npy", tmp_path / "out.npy", AFFINE)
    head = (tmp_path / "out.npy").stat().st_size - 550 * 12
    assert told == [(head, 2400), (head + 2400, 2400)]
