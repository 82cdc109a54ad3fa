"""Folders and patterns on the command line, and the models that they stand for."""

from pathlib import Path

import pytest

from gpu_xform.cli.model_paths import find_models
from gpu_xform.errors import ArgumentError


@pytest.fixture(autouse=True)
def _files() -> None:
    for path in ("in/b.obj", "in/A.STL", "in/.hidden.obj", "in/points.npy", "in/notes.txt", "in/deep/er/[x] ü.ply"):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).touch()
    Path("in/deep/circle").symlink_to("../..", target_is_directory=True)
    Path("in/dead.off").symlink_to("nowhere.off")
    Path("empty/.git").mkdir(parents=True)
    Path("empty/.git/x.obj").touch()


@pytest.mark.parametrize(
    ("typed", "paths"),
    [
        ("in", ["in/A.STL", "in/b.obj", "in/dead.off"]),
        ("in/", ["in/A.STL", "in/b.obj", "in/dead.off"]),
        ("in/deep/**", ["in/deep/er/[x] ü.ply"]),
        ("in/**", ["in/A.STL", "in/b.obj", "in/dead.off", "in/deep/er/[x] ü.ply"]),
        ("in/**/*.ply", ["in/deep/er/[x] ü.ply"]),
        ("in/*.npy", ["in/points.npy"]),
        ("i?/**", ["in/A.STL", "in/b.obj", "in/dead.off", "in/deep/er/[x] ü.ply"]),
        ("in/d*/*", ["in/deep/er/[x] ü.ply"]),
        ("*.wrl", ["*.wrl"]),
    ],
)
def test_what_is_found(typed: str, paths: list[str]) -> None:
    assert find_models([typed])[:2] == (paths, True)


def test_files_stand_for_themselves_and_are_no_whole_set() -> None:
    assert find_models(["in/b.obj", "none.obj", "-", "in/notes.txt"])[:2] == (
        ["in/b.obj", "none.obj", "-", "in/notes.txt"],
        False,
    )
    assert find_models(["in/deep/er/[x] ü.ply"])[:2] == (["in/deep/er/[x] ü.ply"], False)
    assert find_models(["in/b.obj", "in/deep/er"]).is_whole_set


def test_roots_are_the_folders_as_far_as_they_hold_no_pattern() -> None:
    typed = ["in", "in/deep/**", "i?/**", "in/b.obj", "in/d*/*", "in/deep/er/[x] ü.ply", "-"]
    assert find_models(typed).roots == ["in", "in/deep", ".", "in", "in", "in/deep/er"]


def test_links_that_lead_in_a_circle_end() -> None:
    assert find_models(["**"]).paths == sorted(["in/A.STL", "in/b.obj", "in/dead.off", "in/deep/er/[x] ü.ply"])
    assert find_models(["in/**/*.obj"]).paths == ["in/b.obj"]


@pytest.mark.parametrize("typed", ["empty", "empty/**", "in/deep"])
def test_a_folder_without_models_is_an_error(typed: str) -> None:
    with pytest.raises(
        ArgumentError, match=f"{'empty' if 'empty' in typed else 'deep'}.*: no model is there"
    ) as caught:
        find_models([typed])
    assert ("/** takes those of its subfolders too" in str(caught.value)) == ("**" not in typed)
