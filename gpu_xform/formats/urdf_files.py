"""The files that a URDF names: beside it, or in packages of ROS."""

import os
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from ._beside import MAX_PATH_CHARACTERS

_MAX_LEVELS = 8  # above the file, in which packages are looked for
PACKAGE_SCHEMES = ("package://", "model://")
_PACKAGE_FILE = "package.xml"


class ModelFinder:
    """Finds the files that a URDF in a folder means."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self._above = [self._folder, *self._folder.parents][:_MAX_LEVELS]
        self._roots = [
            (Path(place), below)
            for variable, below in (("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share"))
            for place in filter(None, os.environ.get(variable, "").split(os.pathsep))
        ]
        # Without a package, it is the folder above, for its siblings hold the meshes.
        packages = (place for place in self._above if (place / _PACKAGE_FILE).is_file())
        self._package = next(packages, self._folder.parent)

    def find(self, name: str) -> Path | None:
        """Return the file of a name, or None.

        "package://NAME/REST" is REST in the package NAME: a folder of this name among those above the URDF, or beside
        them, or below one of ROS_PACKAGE_PATH or share/ of AMENT_PREFIX_PATH; or else the package that the URDF is in,
        which may have been renamed. Another name is relative to the URDF, and within this package.
        """
        if len(name) > MAX_PATH_CHARACTERS:
            return None
        name = unquote(name)
        scheme = next((scheme for scheme in PACKAGE_SCHEMES if name.startswith(scheme)), None)
        if scheme is None:
            return _find_within(self._package, self._folder / name.removeprefix("file://"))
        package, _, rest = name.removeprefix(scheme).partition("/")
        found = (_find_within(place, place / rest) for place in self._list_places(package))
        return next(filter(None, found), None)

    def _list_places(self, package: str) -> Iterator[Path]:
        if package in ("", ".", ".."):
            return
        for place in self._above:
            if place.name == package:
                yield place
            yield place / package
        for place, below in self._roots:
            yield place / below / package
            if place.name == package:
                yield place
        yield self._package


def _find_within(place: Path, path: Path) -> Path | None:
    """Return a file that lies in a place or below."""
    try:
        if not path.is_file():  # which is one call of the system; to resolve a path takes one for each folder
            return None
        found = path.resolve()
        return found if found.is_relative_to(place.resolve()) else None
    except (OSError, RuntimeError, ValueError):  # a name too long, links in a circle, a NUL
        return None
