"""Model paths: the files that paths, folders and patterns on the command line stand for."""

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from ..errors import ArgumentError
from .options import MODEL_TYPES
from .paths import STDIO

# The name of an .npy file does not say whether it holds the points of a cloud, or the colours or matrices of a model.
FOLDER_TYPES = tuple(f".{name}" for name in MODEL_TYPES if name != "npy")
ALL_TYPES = tuple(f".{name}" for name in MODEL_TYPES)
RECURSIVE = "**"
MAX_FOLDERS = 20_000  # which take a second to list


class ModelPaths(NamedTuple):
    """Paths of models.

    is_whole_set : whether a folder or a pattern was typed, rather than files one by one
    roots : the folders that the paths lie in or below, as far as they were typed without patterns
    """

    paths: Sequence[str]
    is_whole_set: bool
    roots: Sequence[str] = ()


def find_models(typed: Sequence[str]) -> ModelPaths:
    """Return the files that paths stand for: a folder for its models, FOLDER/** also for those of its subfolders.

    Other patterns stand for what they match, and a pattern without a match for itself. Raises `ArgumentError` for a
    folder without models, and `OSError` for one that cannot be read.
    """
    found = [_find(path) for path in typed]
    roots = [_find_root(path) for path in typed if path != STDIO]
    return ModelPaths([path for paths, _ in found for path in paths], any(is_set for _, is_set in found), roots)


def list_near_models(roots: Sequence[str]) -> list[str] | None:
    """Return the models in and below the working folder, `roots` and the folders of these; None if it is a long search.

    Folders that are hidden, links or not readable are passed over.
    """
    return _list_below(dict.fromkeys([".", *(str(Path(root).parent) for root in roots), *roots]), ALL_TYPES)


def count_left_out(typed: str) -> int:
    """Return how many models the subfolders of a folder that was typed hold, which FOLDER/** stands for; else 0."""
    if typed == STDIO or not Path(typed).is_dir():
        return 0
    found = _list_below([typed], FOLDER_TYPES) or []
    return sum(Path(path).parent != Path(typed) for path in found)


def _list_below(places: Iterable[str], types: tuple[str, ...]) -> list[str] | None:
    found, n_folders = list[str](), 0
    for place in places:
        for folder, inner, names in os.walk(place):
            inner[:] = [name for name in inner if not name.startswith(".")]
            models = (name for name in names if name.lower().endswith(types) and not name.startswith("."))
            found += (str(Path(folder, name)) for name in models)
            n_folders += 1
            if n_folders > MAX_FOLDERS:
                return None
    return found


def _find_root(typed: str) -> str:
    """Return the folder that was typed, or that of a file or a pattern as far as it holds no placeholder."""
    import glob

    path = Path(typed)
    while glob.has_magic(str(path)) and not os.path.lexists(path):
        path = path.parent
    return str(path if path.is_dir() else path.parent)


def _find(path: str) -> tuple[list[str], bool]:
    import glob

    if path == STDIO:
        return [path], False
    if Path(path).is_dir():
        hint = f"; {Path(path, RECURSIVE)} takes those of its subfolders too"
        return _require_some(_list_models(path), path, hint), True
    if os.path.lexists(path) or not glob.has_magic(path):
        return [path], False
    if Path(path).name == RECURSIVE:
        parent = str(Path(path).parent)
        folders = [each for each in (_glob(parent) if glob.has_magic(parent) else [parent]) if Path(each).is_dir()]
        return _require_some([model for folder in folders for model in _list_all_models(folder)], path), True
    matches = _glob(path)
    return [model for match in matches for model in _expand_match(match)] or [path], True


def _expand_match(path: str) -> list[str]:
    """Return a file that a pattern matches as it is, and of a folder, as of one that was typed, its models."""
    return _list_models(path) if Path(path).is_dir() else [path]


def _glob(pattern: str) -> list[str]:
    """Return what a pattern matches, sorted, and once where links lead to a folder by several paths."""
    import glob

    matches = sorted(glob.glob(pattern, recursive=True), key=lambda path: (path.count(os.sep), path))  # noqa: PTH207
    once = {(os.path.realpath(Path(path).parent), Path(path).name): path for path in reversed(matches)}
    return sorted(once.values())


def _list_models(folder: str) -> list[str]:
    """Return the models in a folder, sorted: files of known types that are not hidden, links included."""
    with os.scandir(folder) as entries:
        return sorted(
            str(Path(folder, entry.name))
            for entry in entries
            if entry.name.lower().endswith(FOLDER_TYPES)
            and not entry.name.startswith(".")
            and (entry.is_file() or (entry.is_symlink() and not entry.is_dir()))
        )


def _list_all_models(folder: str) -> Iterable[str]:
    """Return the models in a folder and in all folders below it; each folder once, whatever links lead to."""
    above = {str(path) for path in Path(os.path.realpath(folder)).parents}
    return sorted(model for each in _walk(folder, above) for model in _list_models(each))


def _walk(folder: str, seen: set[str]) -> Iterator[str]:
    location = os.path.realpath(folder)
    if location in seen:
        return
    seen.add(location)
    yield folder
    with os.scandir(folder) as entries:
        inner = sorted(entry.name for entry in entries if entry.is_dir() and not entry.name.startswith("."))
    for name in inner:
        yield from _walk(str(Path(folder, name)), seen)


def _require_some(models: list[str], typed: str, hint: str = "") -> list[str]:
    if not models:
        types = ", ".join(FOLDER_TYPES[:-1]) + " or " + FOLDER_TYPES[-1]
        raise ArgumentError(f"{typed}: no model is there, no file of type {types}{hint}")
    return models
