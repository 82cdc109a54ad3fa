"""Materials of OBJ, in the `.mtl` files beside it that `mtllib` names."""

import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path, PureWindowsPath
from typing import Any
from urllib.parse import quote

from .._core.atomic_files import atomic_write
from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from ..geometry.mesh import Mesh
from ._beside import find_beside
from ._losses import name_materials
from ._text import plain_text, quote_end
from ._warn import warn
from .limits import budget

_COLOR = "Kd"
_OPACITIES = ("d", "Tr")
_IMAGE_STATEMENTS = ("bump", "decal", "disp", "norm", "refl")
_SWITCH = "map_aat"  # on or off; all others that begin so name an image
_WORD = re.compile(r"\S+")
_NAME = re.compile(r'"([^"]+)"(?!\S)|(\S+)')
_OPTION_WORD = re.compile(r"-\D.*|on|off|[rgbmlz]|sphere|cube_\w+|[-+.\d]+")  # options and their arguments
_MAX_ARGUMENTS = 3  # of an option: `-s u v w`
_MAX_OPTION_WORDS = 64  # all options that there are, with all of their arguments
_MAX_NAMED = 8
_SUFFIX = ".mtl"


def read_libraries(names: Sequence[str], folder: Path | None) -> dict[str, bytes]:
    """Return the content of the `.mtl` files in `folder` or below, by their names; a missing one is a warning.

    names : what stands behind each `mtllib`: a name, which may hold blanks and quotation marks, or several names
    """
    found: dict[str, bytes] = {}
    missing: dict[str, None] = {}
    read: set[Path] = set()  # a file that goes by several names is read once
    for words in dict.fromkeys(names) if folder is not None else ():
        parts = [words] if _find(folder, words) else list(dict.fromkeys(_split_names(words)))
        paths = [_find(folder, name) for name in parts]
        if not any(paths) and _is_one_name(words, parts):
            missing[quote_end(words)] = None
            continue
        for name, path in zip(parts, paths, strict=True):
            if path is None:
                missing[name] = None
            elif path not in read:
                read.add(path)
                found[name] = budget().read_beside(path)
    pointers = [name for name, data in found.items() if is_lfs_pointer(data)]
    if pointers:
        warn(f"the materials of {', '.join(pointers)} are not there: it is {POINTER_WORDS}")
    if missing:
        more = f" and {len(missing) - _MAX_NAMED} more" if len(missing) > _MAX_NAMED else ""
        named = ", ".join(islice(missing, _MAX_NAMED))
        warn(f"the materials of {named}{more} are not there: no such file lies beside it")
    return found


def _split_names(words: str) -> list[str]:
    """Return the names that stand between blanks; those that hold blanks stand in quotation marks."""
    return [quoted or bare for quoted, bare in _NAME.findall(words)]


def _is_one_name(words: str, parts: Sequence[str]) -> bool:
    """Tell whether words that name no file most likely are one name with blanks: the last part alone ends as such."""
    ends = [part.lower().endswith(_SUFFIX) for part in parts]
    return len(parts) > 1 and '"' not in words and ends[-1] and not any(ends[:-1])


def parse_materials(libraries: Mapping[str, bytes]) -> dict[str, dict[str, Any]]:
    """Return materials as glTF describes them, by name: the first of each name.

    Kd and d are the base colour; every other statement is kept as text in `extras["mtl"]`.
    """
    found: dict[str, dict[str, str]] = {}
    for data in libraries.values():
        current: dict[str, str] = {}
        for keyword, rest in _split_statements(data):
            if keyword == "newmtl":
                current = {}
                found.setdefault(rest, current)
            else:
                current.setdefault(keyword, rest)
    return {name: _describe(name, statements) for name, statements in found.items()}


def find_images(libraries: Mapping[str, bytes], folder: Path | None, used: Collection[str]) -> list[str]:
    """Return the image files that `.mtl` files name and that lie in `folder` or below, by their paths from it.

    Those that the materials in `used` name and that are missing are a warning.
    """
    found: dict[str, None] = {}
    missing: dict[str, dict[str, None]] = {}
    for library, data in libraries.items():
        above = Path(library.replace("\\", "/")).parent.as_posix()
        for rest, materials in _list_image_statements(data).items():
            names = (f"{above}/{name}" for name in _list_names(rest))
            if image := next((name for name in names if _find(folder, name)), None):
                found[Path(image.replace("\\", "/")).as_posix()] = None
            elif named := [name for name in materials if name in used]:
                missing.setdefault(_guess_name(rest), {}).update(dict.fromkeys(named))
    if missing:
        _warn_of_missing(missing)
    return list(found)


def _warn_of_missing(images: Mapping[str, Collection[str]]) -> None:
    """Issue one warning of image files that are not there, each with the materials that name it."""
    parts = [f"{quote_end(name)} of {name_materials(images[name])}" for name in islice(images, _MAX_NAMED)]
    more = f" and {len(images) - _MAX_NAMED} more" if len(images) > _MAX_NAMED else ""
    named = ", ".join(parts) + more
    if len(images) == 1:
        warn(f"the image {named} is not there: no such file lies beside it")
    else:
        warn(f"the images {named} are not there: no such files lie beside it")


def _list_image_statements(data: bytes) -> dict[str, dict[str, None]]:
    """Return what stands in the image statements of a `.mtl` file, and the materials that each stands in."""
    statements: dict[str, dict[str, None]] = {}
    material = ""
    for keyword, rest in _split_statements(data):
        if keyword == "newmtl":
            material = rest
        elif rest and (keyword in _IMAGE_STATEMENTS or (keyword.startswith("map_") and keyword != _SWITCH)):
            statements.setdefault(rest, {})[material] = None
    return statements


def _list_names(rest: str) -> Iterator[str]:
    """Yield what may be the file name in an image statement, which may hold blanks: all, or all behind some options.

    An option has up to three arguments, and a name may begin with what looks like one, and stand in quotation marks.
    """
    for name in _list_ends(rest):
        yield name
        if len(name) > 2 and name[0] == name[-1] == '"':
            yield name[1:-1]


def _list_ends(rest: str) -> Iterator[str]:
    yield rest
    n_left = 0
    for word in islice(_WORD.finditer(rest), _MAX_OPTION_WORDS):
        if word[0].startswith("-"):
            n_left = _MAX_ARGUMENTS + 1  # and the name
        elif n_left:
            n_left -= 1
            yield rest[word.start() :]
        else:
            return


def _guess_name(rest: str) -> str:
    """Return what most likely is the file name in an image statement: what no longer looks like an option."""
    ends = (end for end in _list_ends(rest) if not _OPTION_WORD.fullmatch(end.partition(" ")[0]))
    return next(ends, rest).strip('"').replace("\\", "/")


def list_library_losses(mesh: Mesh, folder: Path | None) -> list[str]:
    """Return which files beside an OBJ file will not be there for one written to `folder`; None for a stream."""
    held = mesh.metadata.get("obj", {})
    libraries = _list_used(mesh)
    if folder is None:
        return [f"the file {name}, whose materials it names" for name in libraries]
    lost = []
    for name, data in libraries.items():
        path = _place(folder, name) or _find(folder, name)
        if path is None:
            lost.append(f"the file {name}, whose materials it names")
        elif _is_other(path, data):
            lost.append(f"the materials of {name}, for another file of that name is there")
    return lost + [f"the image {name}" for name in held.get("images", ()) if libraries and not _find(folder, name)]


def write_libraries(mesh: Mesh, folder: Path) -> None:
    """Write the `.mtl` files that a mesh was read with beside its new file, unless they are there."""
    for name, data in _list_used(mesh).items():
        path = _place(folder, name)
        if path is not None and not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            with atomic_write(path) as file:
                file.write(data)


def _place(folder: Path, name: str) -> Path | None:
    """Return where a `.mtl` file goes; None for a name of another type, that is hidden, or that leads elsewhere."""
    path = PureWindowsPath(name)  # with the slashes of both systems, and drives
    is_plain = path.suffix.lower() == _SUFFIX and not path.anchor and not any(p.startswith(".") for p in path.parts)
    place = folder.joinpath(*path.parts)
    return place if is_plain and place.resolve().is_relative_to(folder.resolve()) else None


def list_libraries(material: Mapping[str, Any]) -> tuple[str, ...]:
    """Return what stands behind each `mtllib`; glTF may have a material of that name."""
    found = material.get("mtllib")
    return found if isinstance(found, tuple) else ()


def _list_used(mesh: Mesh) -> Mapping[str, bytes]:
    """Return the `.mtl` files that a mesh was read with, if it still names any."""
    return mesh.metadata.get("obj", {}).get("libraries", {}) if "mtllib" in mesh.attributes.material else {}


def _is_other(path: Path, data: bytes) -> bool:
    return path.exists() and not (path.is_file() and path.read_bytes() == data)


def _find(folder: Path | None, name: str) -> Path | None:
    """Return a file in `folder` or below; its name is meant letter for letter, but for the slashes of Windows."""
    name = name.replace("\\", "/")
    if folder is None or not os.path.exists(f"{folder}/{name}"):  # noqa: PTH110 - pathlib takes ten times as long
        return None
    return find_beside(folder, folder, quote(name))


def _split_statements(data: bytes) -> Iterator[tuple[str, str]]:
    """Yield the keyword and the rest of each statement."""
    for line in plain_text(data).decode("utf-8", "replace").split("\n"):
        keyword, _, rest = line.strip().replace("\t", " ").partition(" ")
        if keyword != "newmtl" and not keyword.startswith("map_"):
            rest = rest.partition("#")[0]
        if keyword and not keyword.startswith("#"):
            yield keyword, rest.strip()


def _describe(name: str, statements: Mapping[str, str]) -> dict[str, Any]:
    """Return a material of glTF."""
    left = dict(statements)
    color = _parse_color(left.get(_COLOR, ""))
    if color is not None:
        del left[_COLOR]
    opacity = None
    for keyword in _OPACITIES:
        value = _parse_opacity(keyword, left.get(keyword, ""))
        if value is not None:
            del left[keyword]
            opacity = value if opacity is None else opacity
    made: dict[str, Any] = {"name": name}
    if color is not None or opacity is not None:
        factor = [*(color or (1.0, 1.0, 1.0)), 1.0 if opacity is None else opacity]
        made["pbrMetallicRoughness"] = {"baseColorFactor": factor, "metallicFactor": 0.0}
        if factor[3] < 1.0:
            made["alphaMode"] = "BLEND"
    return made | ({"extras": {"mtl": left}} if left else {})


def _parse_color(text: str) -> tuple[float, float, float] | None:
    """Return red, green and blue in 0..1; one number stands for all three. None for other ways to say a colour."""
    numbers = _parse_fractions(text)
    if len(numbers) == 1:
        numbers *= 3
    return (numbers[0], numbers[1], numbers[2]) if len(numbers) == 3 else None


def _parse_opacity(keyword: str, text: str) -> float | None:
    numbers = _parse_fractions(text.removeprefix("-halo "))
    return None if len(numbers) != 1 else 1.0 - numbers[0] if keyword == "Tr" else numbers[0]


def _parse_fractions(text: str) -> list[float]:
    """Return numbers in 0..1; none if a word is no number."""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return []
    return [min(max(number, 0.0), 1.0) for number in numbers] if all(n == n for n in numbers) else []
