"""The files that a URDF names: beside it, or in packages of ROS."""

import os
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from ._beside import MAX_PATH_CHARACTERS

_MAX_LEVELS = 8  # above the file, in which packages are looked for
PACKAGE_SCHEMES = ("package://", "model://")
_PACKAGE_FILE = "package.xml"


def find_model(name: str, folder: Path | None) -> Path | None:
    """Return the file that a URDF in `folder` means, or None.

    "package://NAME/REST" is REST in the package NAME: a folder of this name among those above the URDF, or beside them,
    or below one of ROS_PACKAGE_PATH or share/ of AMENT_PREFIX_PATH; or else the package that the URDF is in, which may
    have been renamed. Another name is relative to the URDF, and within this package.
    """
    if folder is None or len(name) > MAX_PATH_CHARACTERS:
        return None
    folder = folder.resolve()
    name = unquote(name)
    scheme = next((scheme for scheme in PACKAGE_SCHEMES if name.startswith(scheme)), None)
    if scheme is None:
        return _find_within(_find_package(folder), folder / name.removeprefix("file://"))
    package, _, rest = name.removeprefix(scheme).partition("/")
    for place in _list_places(package, folder):
        found = _find_within(place, place / rest)
        if found is not None:
            return found
    return None


def _find_package(folder: Path) -> Path:
    """Return the package that a folder is in; without one, the folder above, for its siblings hold the meshes."""
    above = [folder, *folder.parents][:_MAX_LEVELS]
    return next((place for place in above if (place / _PACKAGE_FILE).is_file()), folder.parent)


def _list_places(package: str, folder: Path) -> Iterator[Path]:
    if package in ("", ".", ".."):
        return
    for place in [folder, *folder.parents][:_MAX_LEVELS]:
        if place.name == package:
            yield place
        yield place / package
    for variable, below in (("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")):
        for place in map(Path, filter(None, os.environ.get(variable, "").split(os.pathsep))):
            yield place / below / package
            if place.name == package:
                yield place
    yield _find_package(folder)


def _find_within(place: Path, path: Path) -> Path | None:
    """Return a file that lies in a place or below."""
    try:
        found = path.resolve()
        return found if found.is_relative_to(place.resolve()) and found.is_file() else None
    except (OSError, RuntimeError, ValueError):  # a name too long, links in a circle, a NUL
        return None
