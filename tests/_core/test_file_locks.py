"""Locks of files, and the folders that appear whole: what a run before, another run or a file system may do to them."""

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from gpu_xform._core import file_locks
from gpu_xform._core.atomic_files import atomic_folder
from gpu_xform._core.file_locks import describe_process, hold_lock_file, try_lock
from tests.support.python_run import linux_only


def refuse(holder: str) -> Exception:
    return RuntimeError(holder)


def test_a_lock_names_its_holder_alone_whatever_a_killed_run_left_there(tmp_path: Path) -> None:
    path = tmp_path / "x.lock"
    path.write_text("process 1 on a machine of a long name, which was killed" * 9)
    with hold_lock_file(path, refuse):
        with pytest.raises(RuntimeError) as caught, hold_lock_file(path, refuse):
            pass
        assert str(caught.value) == describe_process()
    assert not path.exists()


def test_a_lock_of_a_file_that_its_holder_deleted_meanwhile_is_taken_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between opening the file and locking it, the run that held it ends."""
    path = tmp_path / "x.lock"
    locked: list[Any] = []

    def lock(file: Any) -> bool:
        locked.append(file)
        if len(locked) == 1:
            path.unlink()
        return try_lock(file)

    monkeypatch.setattr(file_locks, "try_lock", lock)
    with hold_lock_file(path, refuse):
        assert path.exists()
        with pytest.raises(RuntimeError, match=r"^process "), hold_lock_file(path, refuse):
            pass
    assert locked[0].closed
    assert len(locked) == 3


@linux_only
def test_a_file_system_without_locks_locks_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", fail)
    with (tmp_path / "x").open("wb") as file:
        assert try_lock(file)


def write_half(target: Path, others: list[str]) -> None:
    with atomic_folder(target, ["0.png"], "{}.png") as folder:
        (folder / "0.png").write_bytes(b"half")
        for name in others:
            (target / name).write_bytes(b"whole")
        raise ZeroDivisionError


@pytest.mark.parametrize("others", [[], ["theirs.txt"]])
def test_a_new_folder_of_a_block_that_raises_is_deleted_unless_others_put_something_there(
    others: list[str], tmp_path: Path
) -> None:
    target = tmp_path / "frames"
    with pytest.raises(ZeroDivisionError):
        write_half(target, others)
    assert target.exists() == bool(others)
    assert [path.name for path in target.glob("*")] == others


@pytest.mark.parametrize("others", [[], ["0.png"]])
def test_an_old_folder_of_a_block_that_raises_stays_as_it_is(others: list[str], tmp_path: Path) -> None:
    for name in others:
        (tmp_path / name).write_bytes(b"old")
    with pytest.raises(ZeroDivisionError):
        write_half(tmp_path, [])
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [(name, b"old") for name in others]
