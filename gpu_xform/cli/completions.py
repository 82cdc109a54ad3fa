"""Completions of values: the words and the types of files that options take, as functions of a shell."""

import argparse
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from ..drawing.dash_patterns import LINE_TYPES
from ..drawing.enums import HIDDEN_STYLES, SHADE, SHADINGS
from ..drawing.page import LANDSCAPE, PAPERS, UNITS_MM
from ..drawing.sheet import PROJECTIONS, VIEW_NAMES
from ..errors import GpuXformError
from ..geometry.edges import EDGE_SETS
from ..raster.names import RASTERIZERS
from . import options as groups
from .argument_types import models, paths, pictures, styles, vectors
from .image_files import FORMATS

ANY_FILE = ("*",)
ARRAY_FILE = ("npy",)
ANIMATION_TYPES = ("gif", "webp", "png", "apng", "mp4", "webm", "html")


@dataclass(frozen=True)
class Completion:
    """What a shell offers for a value: words, files of some types, and folders if there are files.

    words : the words; of a list, each may follow a comma
    file_types : the endings of the files, without dots, or `ANY_FILE`
    """

    words: tuple[str, ...] = ()
    file_types: tuple[str, ...] = ()
    is_list: bool = False

    @property
    def patterns(self) -> tuple[str, ...]:
        """The files as patterns of a shell; each letter in both cases."""
        if self.file_types == ANY_FILE:
            return ANY_FILE
        letters = ("".join(f"[{c}{c.upper()}]" if c.isalpha() else c for c in name) for name in self.file_types)
        return tuple(f"*.{name}" for name in letters)

    @property
    def function(self) -> str:
        """The name of the function; shtab lets bash treat what it prints as files if the name says so."""
        return f"_gpu_xform_{'file' if self.file_types else 'word'}_{sha256(repr(self).encode()).hexdigest()[:8]}"

    def format_function(self, shell: str) -> str:
        """Return the function in bash, which prints what begins as its argument does, or in zsh."""
        body = "\n".join(self._list_bash() if shell == "bash" else self._list_zsh())
        return f"{self.function}() {{\n{body}\n}}\n"

    def format_tcsh(self) -> str:
        """Return what tcsh, which has no functions, can do of it: words, or else files."""
        return f"({' '.join(self.words)})" if self.words else f"f:{{{','.join(self.patterns)}}}"

    def _list_bash(self) -> Iterable[str]:
        yield '  local typed="${1//\\\\/}"'  # as the shell has it after the quotes that -o filenames adds
        if self.words:
            words = " ".join(self.words)
            if self.is_list:
                yield f'  compgen -P "${{typed%"${{typed##*,}}"}}" -W \'{words}\' -- "${{typed##*,}}"'
            else:
                yield f"  compgen -W '{words}' -- \"$typed\""
        for pattern in self.patterns:
            yield f"  compgen -f -X '!{pattern}' -- \"$typed\""
        if self.file_types:
            yield '  compgen -d -- "$typed"'

    def _list_zsh(self) -> Iterable[str]:
        choices = []
        if self.words:
            words = " ".join(self.words)
            choices.append(f"'words:value:{f'_values -s , value {words}' if self.is_list else f'({words})'}'")
        if self.file_types:
            choices.append(f"'files:file:_files -g \"({'|'.join(self.patterns)})\"'")
        yield f"  _alternative {' '.join(choices)}"


MODELS = Completion(file_types=groups.MODEL_TYPES)
POINTS = Completion(file_types=(*groups.MODEL_TYPES, "zarr"))
PICTURES = Completion(file_types=("png",))
BY_TYPE: Mapping[Any, Completion] = {
    paths.parse_array_file: Completion(file_types=ARRAY_FILE),
    styles.parse_dash: Completion(tuple(name for name, _ in LINE_TYPES.values())),
    vectors.parse_direction: Completion(tuple(f"{sign}{axis.upper()}" for axis in styles.AXES for sign in "+-")),
    styles.parse_edge_sets: Completion(EDGE_SETS, ARRAY_FILE, is_list=True),
    styles.parse_hatch: Completion(("auto",)),
    styles.parse_hidden: Completion(HIDDEN_STYLES),
    vectors.parse_kernel: Completion(file_types=ANY_FILE),
    styles.parse_labels: Completion(styles.LABEL_SETS, styles.LABEL_FILES),
    styles.parse_line_width: Completion(("auto",)),
    vectors.parse_matrix: Completion(file_types=ANY_FILE),
    models.parse_pins: Completion(models.PIN_NAMES, is_list=True),
    pictures.parse_projection: Completion(PROJECTIONS),
    pictures.parse_rasterizer: Completion(RASTERIZERS),
    paths.parse_report_path: Completion(file_types=paths.REPORT_TYPES),
    styles.parse_scalars: Completion(styles.AXES, ARRAY_FILE),
    styles.parse_shading: Completion(SHADINGS),
    paths.parse_sheet_path: Completion(file_types=paths.PICTURE_TYPES),
    pictures.parse_units: Completion(tuple(UNITS_MM)),
    pictures.parse_views: Completion(VIEW_NAMES, is_list=True),
}
# By the destination of a value, with or without its command, or by what its option calls it.
BY_NAME: Mapping[str, Completion] = {
    "animate output": Completion(file_types=ANIMATION_TYPES),
    "convolve input": Completion(file_types=ANY_FILE),
    "convolve output": Completion(file_types=tuple(FORMATS)),
    "info models": POINTS,
    "render output": Completion(file_types=(*paths.PICTURE_TYPES, *paths.PAGE_TYPES)),
    "simulate model": Completion(("cloth", "curtain", "hair"), groups.MODEL_TYPES),
    "simulate output": Completion(file_types=ANIMATION_TYPES),
    "transform inputs": POINTS,
    "transform output": POINTS,
    "file_type": Completion(groups.MODEL_TYPES),
    "font": Completion(file_types=("ttf", "otf", "ttc", "otc")),
    "matrix_table": Completion(file_types=("json", "csv", "txt")),
    "paper": Completion((*PAPERS, *(f"{name}-{LANDSCAPE}" for name in PAPERS))),
    "MODEL": MODELS,
    "'MODEL ...'": MODELS,
    "NPY": Completion(file_types=ARRAY_FILE),
    "PNG": PICTURES,
}


def find_completions(commands: Mapping[str, argparse.ArgumentParser]) -> dict[argparse.Action, Completion]:
    """Return what completes the values of the commands' options and their other arguments; lists the adapters."""
    colors = _list_colors()
    by_type = {
        **BY_TYPE,
        styles.parse_color: Completion(colors),
        styles.parse_line_color: Completion(("face", "file", *colors)),
        styles.parse_fill: Completion((SHADE, "face", "file", *colors), ARRAY_FILE),
        styles.parse_colormap: Completion(_list_colormaps()),
    }
    adapters = _list_adapters()
    found = {}
    for command, parser in commands.items():
        for action in parser._actions:  # argparse shows them nowhere else
            if action.choices:
                completion: Completion | None = Completion(tuple(map(str, action.choices)))
            elif action.dest == "adapter":
                completion = Completion((*adapters, "host") if "host for" in (action.help or "") else adapters)
            else:
                keys = (f"{command} {action.dest}", action.dest, action.metavar)
                named = (BY_NAME[key] for key in keys if isinstance(key, str) and key in BY_NAME)
                completion = next(named, by_type.get(action.type))
            if completion is not None and completion != Completion():
                found[action] = completion
    return found


def _list_colors() -> tuple[str, ...]:
    from PIL import ImageColor

    return tuple(ImageColor.colormap)


def _list_colormaps() -> tuple[str, ...]:
    """Return the names that stand for one colormap, without those for so many colours of one."""
    from cmap import Colormap

    return tuple(sorted(name for name in Colormap.catalog().short_keys() if not re.search(r"_(\d+|discrete)$", name)))


def _list_adapters() -> tuple[str, ...]:
    """Return the first words of the adapters' names, by which they are chosen; none where they cannot be listed."""
    try:
        from ..gpu.adapters import adapters

        names = [adapter.name for adapter in adapters()]
    except GpuXformError:
        return ()
    return tuple(dict.fromkeys(word for name in names for word in re.findall(r"^[\w.+-]+", name)))
