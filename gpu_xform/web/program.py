"""What the program of a page is made of: scripts, the WGSL stages that they run, and what both languages share."""

import json
import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ..drawing import (
    build_layer,
    camera,
    dash_chains,
    dash_patterns,
    enums,
    shading,
    silhouettes,
)
from ..geometry import chains
from ..gpu import layouts
from ..gpu.wgsl import IMPORT, REAL, Sources, installed_sources
from ..imaging.colors import COLOR_CYCLE, to_rgba
from ..raster import dashes, line_batches, line_stage, rasterizer, tiles, triangles
from ..viewer import controls, key_bindings, orbit, style_overrides
from ..viewer.key_bindings import KEYS, POINTER

SCRIPTS = (
    *(
        "matrices",
        "arrays",
        "wgsl",
        "camera",
        "mesh",
        "style",
        "draw_list",
        "gpu",
        "flat",
        "controls",
        "player",
        "page",
    ),
)
STAGES = (
    *("vertex_transform", "measure_chains", "depth_small_triangles", "depth_large_triangles", "composite_triangles"),
    *("accumulate_lines", "composite_lines", "composite_colored_lines"),
    *("rasterize_aliased_lines", "composite_aliased_lines"),
)
NUMBER_TYPE = "f32"
_LEFT_OUT = ("S", "H, ?", "Q, Esc")  # of the window's keys, those that a page has in its own way, or has not
_OWN_KEYS = (("S", "save the picture as PNG"), ("H, ?", "show or hide this list"))
_TOUCH = (("fingers", "one rotates, two move and zoom"),)
_PLAYER_KEYS = (("Space", "play or pause the animation"),)
_LAYOUTS = ("TILE", "LINE_STYLE", "FACES", "VERTEX_TRANSFORM")
_SHARED: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (build_layer, ("CLOUD_POINT_SIZE_PX",)),
    (camera, ("DEFAULT_FOV_Y", "DEFAULT_MARGIN", "FAR_FRACTION", "NEAR_FRACTION")),
    (chains, ("MAX_TURN_DEGREES",)),
    (
        controls,
        ("RADIANS_PER_HEIGHT", "ROTATION_KEYS", "SIDE_KEYS", "UNITS_PER_NOTCH", "MAX_NOTCHES", "ZOOM_PER_NOTCH"),
    ),
    (dash_chains, ("CHAIN_IS_FIRST", "CHAIN_IS_REVERSED")),
    (dash_patterns, ("HIDDEN_DASHES", "MAX_DASHES", "MIN_HIDDEN_DASH_WIDTH_PX")),
    (dashes, ("EDGES_PER_SECTION",)),
    (enums, ("HIDDEN_FADE_ALPHA", "HIDDEN_STYLES")),
    (
        line_batches,
        (
            *("BUSY_INVOCATIONS", "MAX_PIXELS_PER_INVOCATION", "MIN_COLUMNS_PER_INVOCATION", "MIN_EDGE_BITS"),
            *("MIN_SIMPLE_DASH_PX", "NO_DASH_PX"),
        ),
    ),
    (
        line_stage,
        ("ABSORBANCE_STEPS_PER_E", "MAX_EDGES_FOR_DEEP_K_BUFFER", "MAX_NARROW_WIDTH_PX", "MIN_TRANSMITTANCE"),
    ),
    (orbit, ("DIRECTION_EPSILON", "MAX_DISTANCE_RADII", "MIN_DISTANCE_RADII", "SIDES")),
    (rasterizer, ("MAX_DEPTH_MARGIN_PX",)),
    (shading, ("AMBIENT",)),
    (silhouettes, ("EDGE_ON_SINE",)),
    (key_bindings, ("EDGE_CYCLE",)),
    (tiles, ("TILE_SIDE_PX",)),
    (triangles, ("MAX_FEW_TRIANGLES", "PIXELS_PER_FLAT")),
)
_TYPES = {"f": "Float32", "i": "Int32", "u": "Uint32"}
_JS_IMPORT = re.compile(r"^import \{[^}]*\} from \"\./\w+\.js\";\n", re.MULTILINE)
_JS_EXPORT = re.compile(r"^export ", re.MULTILINE)
_STYLE_SPACE = re.compile(r"\s*([{};,]|(?<![\s:]):(?=\s)|\n)\s*")


def describe_program() -> dict[str, Any]:
    """Return the data of a program, for JSON: stages, layouts of structs, constants and markup."""
    stages = installed_sources().stages
    return {
        "stages": {
            name: {"file": Path(stages[name].file).stem, "entry_points": dict(stages[name].entry_points)}
            for name in STAGES
        },
        "layouts": {name: describe_layout(getattr(layouts, name)) for name in _LAYOUTS},
        "constants": collect_constants(),
        "style": strip_style(read_text("page.css")),
        "controls": read_text("controls.html"),
        "player": read_text("player.html"),
        "help": list_keys((*KEYS, *_OWN_KEYS)),
        "playerHelp": list_keys(_PLAYER_KEYS, pointer=()),
    }


def collect_wgsl(sources: Sources) -> dict[str, str]:
    """Return the texts of the stages' files and of all that they import, by the files' names, which differ."""
    texts: dict[str, str] = {}

    def add(file: str) -> None:
        own = Path(file).stem
        if own in texts:
            return
        texts[own] = (sources.folder / file).read_text("utf-8")
        for line in texts[own].splitlines():
            found = IMPORT.fullmatch(line)
            if found:
                name = f"{REAL}_{NUMBER_TYPE}" if found[1] == REAL else found[1]
                add(f"shared/{name}.wgsl")

    for stage in STAGES:
        add(sources.stages[stage].file)
    return texts


def describe_layout(dtype: np.dtype[Any]) -> dict[str, Any]:
    """Return the size of a struct in bytes, and the offset and type of each field."""
    fields = {}
    for name, (kind, offset, *_) in (dtype.fields or {}).items():
        if kind.fields:
            fields[name] = {"offset": offset, **describe_layout(kind)}
        else:
            fields[name] = {"offset": offset, "type": _TYPES[kind.base.kind]}
    return {"size": dtype.itemsize, "fields": fields}


def collect_constants() -> dict[str, Any]:
    """Return the numbers and names that the scripts have from Python, so that neither can be changed alone."""
    constants = {name: getattr(module, name) for module, names in _SHARED for name in names}
    named = {"LIGHT": style_overrides.LIGHT, "DARK": style_overrides.DARK}
    constants |= {name: {"name": color, "color": to_rgba(color, name)} for name, color in named.items()}
    constants["DEFAULT_FILL"] = to_rgba(style_overrides.DEFAULT_FILL, "fill")
    constants["COLOR_CYCLE"] = [to_rgba(color, "color") for color in COLOR_CYCLE]
    plain: dict[str, Any] = json.loads(json.dumps(constants, default=_as_plain))
    return plain


def list_keys(
    keys: Sequence[tuple[str, str]], *, pointer: Sequence[tuple[str, str]] = (*POINTER, *_TOUCH)
) -> list[list[str]]:
    """Return the rows of a list of keys: names, what they do, and the key that a click stands for, if any."""
    rows = [[what, effect, ""] for what, effect in pointer]
    for names, effect in keys:
        if (names, effect) in KEYS and names in _LEFT_OUT:
            continue
        first = names.split(",")[0]
        rows.append([names, effect, {"Space": " "}.get(first, first.lower() if len(first) == 1 else first)])
    return rows


def _as_plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else list(value)


def join_scripts() -> str:
    """Return the modules of `js/` as one, without imports and exports."""
    return "".join(_JS_EXPORT.sub("", _JS_IMPORT.sub("", read_script(name))) for name in SCRIPTS)


def read_script(name: str) -> str:
    """Return the text of a module of `js/`."""
    return read_text(f"js/{name}.js")


def read_text(name: str) -> str:
    """Return the text of a file beside this one."""
    return files(__package__).joinpath(name).read_text("utf-8")


def strip_style(text: str) -> str:
    """Return a style sheet without comments and spaces between its words and signs."""
    return _STYLE_SPACE.sub(r"\1", re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)).replace(";}", "}").strip()
