"""WGSL sources: finds the files, resolves `#import`, and knows which file and line each resolved line comes from."""

import functools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import NamedTuple

from ..errors import ShaderError
from .stages import Stage, read_stages

IMPORT = re.compile(r"#import\s+(\w+)\s*(?://.*)?")
REAL = "real"  # the one import that stands for several files, of which the stage's number type chooses
BINDING = re.compile(r"^@group\(0\) @binding\((\d+)\) var(?:<[\w, ]+>)? (\w+):", re.MULTILINE)
LOCATION = re.compile(r"(?P<arrow>┌─ )\S+:(?P<line>\d+):(?P<column>\d+)")  # as naga's messages give one
GUTTER = re.compile(r"^(?P<line>\d+)(?P<bar> +│)", re.MULTILINE)
MARKED = re.compile(r"^(?P<line>\d+) +│.*\n +│[^^╰\n]*\^", re.MULTILINE)  # a line, and carets below a part of it


class Origin(NamedTuple):
    """Where a line stands: its file, relative to the folder of WGSL files, and its number, counted from 1."""

    file: str
    line: int


@dataclass(frozen=True)
class Source:
    """The WGSL of a stage without imports, and the origin of each of its lines."""

    code: str
    origins: tuple[Origin, ...]

    @functools.cached_property
    def bindings(self) -> Mapping[str, int]:
        """The numbers of the variables in binding group 0, by name."""
        return {name: int(number) for number, name in BINDING.findall(self.code)}

    def relocate(self, message: str) -> tuple[str, Origin | None]:
        """Return a compiler's message with lines counted in their own files, and the origin that it is about."""
        found = MARKED.search(message) or LOCATION.search(message)
        if found is None or not self._holds(found["line"]):
            return message, None

        def own_location(match: re.Match[str]) -> str:
            if not self._holds(match["line"]):
                return match[0]
            file, line = self.origins[int(match["line"]) - 1]
            return f"{match['arrow']}{file}:{line}:{match['column']}"

        def own_number(match: re.Match[str]) -> str:
            if not self._holds(match["line"]):
                return match[0]
            return f"{self.origins[int(match['line']) - 1].line:<{len(match['line'])}}{match['bar']}"

        return GUTTER.sub(own_number, LOCATION.sub(own_location, message)), self.origins[int(found["line"]) - 1]

    def _holds(self, line: str) -> bool:
        return 1 <= int(line) <= len(self.origins)

    def dump(self, folder: Path, name: str) -> None:
        """Write the resolved code to `name.wgsl` and the origin of each line to `name.lines` in `folder`."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.wgsl").write_text(self.code + "\n", "utf-8")
        lines = [f"{number}\t{file}:{line}\n" for number, (file, line) in enumerate(self.origins, 1)]
        (folder / f"{name}.lines").write_text("".join(lines), "utf-8")


class Sources:
    """The stages of one folder of WGSL files, each resolved once."""

    def __init__(self, folder: Traversable) -> None:
        self.folder = folder
        self._stages: dict[str, Stage] | None = None
        self._resolved: dict[tuple[str, str | None], Source] = {}
        self._seen: dict[Path, tuple[int, int]] = {}

    @property
    def stages(self) -> Mapping[str, Stage]:
        """The rows of the folder's table, by name."""
        if self._stages is None:
            self._stages = read_stages(self.folder)
        return self._stages

    def source(self, name: str, number_type: str | None = None) -> Source:
        """Return a stage's WGSL for a number type, None for a stage without; raise `ShaderError` if there is none."""
        key = (name, number_type)
        if key not in self._resolved:
            stage = self.stages.get(name)
            if stage is None:
                raise ShaderError(f"no stage {name!r} in the table of {self.folder}")
            if (number_type or "none") not in (stage.number_types or ("none",)):
                allowed = " or ".join(stage.number_types) or "none"
                raise ShaderError(f"number type of stage {name!r} must be {allowed}, got {number_type}")
            self._resolved[key] = resolve(self.folder, stage.file, number_type)
        return self._resolved[key]

    def reload(self) -> None:
        """Read everything anew when it is next needed."""
        self._stages = None
        self._resolved.clear()

    def have_changed(self) -> bool:
        """Say whether a file of the folder, which is one of the file system, has changed since the last call."""
        files = [file for file in Path(str(self.folder)).rglob("*") if file.is_file()]
        seen = {file: (file.stat().st_mtime_ns, file.stat().st_size) for file in files}
        before, self._seen = self._seen, seen
        return seen != before


@functools.cache
def installed_sources() -> Sources:
    """Return the package's own WGSL files."""
    return Sources(shader_folder())


def shader_folder() -> Traversable:
    """Return the folder of WGSL files: inside the package in a wheel, at the top of the tree in a checkout."""
    packaged = resources.files("gpu_xform") / "wgsl"
    if packaged.is_dir():
        return packaged
    # An editable install does not see the wheel's copy.
    checkout = Path(__file__).parents[2] / "wgsl"
    if checkout.is_dir():
        return checkout
    raise ShaderError(f"the WGSL files are neither in {packaged} nor in {checkout}: the installation is incomplete")


def resolve(folder: Traversable, file: str, number_type: str | None = None) -> Source:
    """Replace each `#import name` line of `file` by `shared/name.wgsl`, once, and `#import real` by the number type's.

    Raises `ShaderError` with file and line for an unknown import.
    """
    if not (folder / file).is_file():
        raise ShaderError(f"no {file} in {folder}")
    lines: list[str] = []
    origins: list[Origin] = []
    included: set[str] = set()

    def include(file: str) -> None:
        for number, line in enumerate((folder / file).read_text("utf-8").splitlines(), 1):
            if not line.startswith("#"):
                lines.append(line)
                origins.append(Origin(file, number))
                continue
            directive = IMPORT.fullmatch(line)
            if directive is None:
                raise ShaderError(f"{file}:{number}: expected '#import name', got {line!r}")
            name = f"{REAL}_{number_type}" if directive[1] == REAL and number_type else directive[1]
            imported = f"shared/{name}.wgsl"
            if not (folder / imported).is_file():
                raise ShaderError(f"{file}:{number}: no {imported} to import")
            if name not in included:
                included.add(name)
                include(imported)

    include(file)
    return Source("\n".join(lines), tuple(origins))
