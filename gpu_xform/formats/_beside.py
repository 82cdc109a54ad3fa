"""Files beside a model file, which it names."""

from pathlib import Path
from urllib.parse import unquote

MAX_PATH_CHARACTERS = 4096  # no system has longer ones, and each part of a name is looked for with all before it


def find_beside(root: Path | None, folder: Path | None, name: str) -> Path | None:
    """Return the file that `name` means in `folder`, if it lies in `root` or below; no other file may be opened."""
    path = place_beside(root, folder, name)
    try:
        return path if path is not None and path.is_file() else None
    except OSError:  # a name too long
        return None


def place_beside(root: Path | None, folder: Path | None, name: str) -> Path | None:
    """Return the path that `name` means in `folder`, if it leads into `root` or below, where no file need be."""
    if root is None or folder is None or len(name) > MAX_PATH_CHARACTERS:
        return None
    try:
        path = (folder / unquote(name)).resolve()
        return path if path.is_relative_to(root.resolve()) else None
    except (OSError, RuntimeError, ValueError):  # a name too long, links in a circle, a NUL
        return None
