"""The program of a page in as few bytes as can be: its names short, and nothing in it that only people read."""

import functools
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..gpu.wgsl import IMPORT, REAL, installed_sources
from .arrays import encode_bytes
from .program import NUMBER_TYPE, collect_wgsl, describe_program, join_scripts, strip_style
from .scopes import read_script, read_wgsl
from .short_names import SCRIPT, TABLES, ShortNames, choose_names
from .tokens import is_text, join_script, join_wgsl, split_script, split_wgsl

# Names that the program declares, and browsers have too: as properties, or as members of dictionaries that they take.
_PLATFORM = (
    "alphaMode apply at bind binding buffer bytesPerRow clearValue code colorAttachments compute constants device"
    " direction draw end entries entryPoint files fill format fragment from height hidden id key label layout"
    " length lineWidth list loadOp maxBufferSize maxStorageBufferBindingSize measure module origin passive remove"
    " requiredLimits resource scale shift size source storeOp target targets textContent texture toggle type usage"
    " values vertex view width willReadFrequently write"
)
_PUBLIC = (  # what other scripts may use of `window.livePage`
    "clipFromWorld decode drawNow frame isReady name pixelRatio press readPixels readPixelsOf redraw renderer whenDone"
)
_NEEDLESS_ZERO = re.compile(r"^(-?)0(?=\.[1-9]|\.0\d)|\.0$")
_INLINE = re.compile(
    r"(?P<start><(?P<tag>style|script)(?: type=\"module\")?>)\n(?P<text>.*?)(?=</(?P=tag)>)", re.DOTALL
)
KEPT_NAMES = frozenset(f"{_PLATFORM} {_PUBLIC}".split())


@dataclass(frozen=True)
class Program:
    """A script that returns the function `openPage`, the names in it for those in its sources, and its WGSL.

    files : texts by number; a line `#import` names another one
    numbers : of the files, by their names
    """

    text: str
    names: ShortNames
    files: Mapping[str, str]
    numbers: Mapping[str, str]


@functools.cache
def make_program() -> Program:
    """Return the program of all pages."""
    script = read_script(split_script(join_scripts()))
    wgsl = {name: read_wgsl(split_wgsl(text)) for name, text in collect_wgsl(installed_sources()).items()}
    data = describe_program()
    texts = {token.strip('"') for token in script.tokens if is_text(token)}
    kept = KEPT_NAMES | texts | set(_list_texts(data["constants"]))
    names = choose_names(script, wgsl, {"files", *_list_keys(data)}, kept)
    numbers = {name: str(i) for i, name in enumerate(wgsl)}
    data["files"] = {numbers[name]: _write_wgsl(names.rename(name, text), numbers) for name, text in wgsl.items()}
    for stage in data["stages"].values():
        stage["file"] = numbers[stage["file"]]
        stage["entry_points"] = {kind: names.shared.get(name, name) for kind, name in stage["entry_points"].items()}
    code = join_script(names.rename(SCRIPT, script))
    text = f"{code}return {names.shared['openPage']}.bind(null,{write_data(names.rename_keys(data))})"
    return Program(text, names, data["files"], numbers)


@functools.cache
def encode_program() -> str:
    """Return the program as the text that a page holds."""
    return encode_bytes(make_program().text.encode())


@functools.cache
def shorten_markup(text: str) -> str:
    """Return a page of HTML with its styles and scripts made short."""

    def shorten(found: re.Match[str]) -> str:
        if found["tag"] == "style":
            return f"{found['start']}{strip_style(found['text'])}"
        script = read_script(split_script(found["text"]))
        return found["start"] + join_script(choose_names(script, {}, (), ()).rename(SCRIPT, script))

    return _INLINE.sub(shorten, text).replace(">\n<", "><")


def _write_wgsl(tokens: list[str], numbers: Mapping[str, str]) -> str:
    """Return a WGSL file that imports others by their numbers."""

    def name_import(token: str) -> str:
        found = IMPORT.fullmatch(token)
        if found is None:
            return token
        return f"#import {numbers[f'{REAL}_{NUMBER_TYPE}' if found[1] == REAL else found[1]]}"

    return join_wgsl([name_import(token) if token[0] == "#" else token for token in tokens])


def write_data(value: Any) -> str:
    """Return data, as JSON has it, as a script does."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{_write_key(key)}:{write_data(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ",".join(map(write_data, value)) + "]"
    if isinstance(value, float):
        return _write_float(value)
    if isinstance(value, str) and not set("`\\$") & set(value):
        return f"`{value}`"
    return json.dumps(value, ensure_ascii=False)


def _write_float(value: float) -> str:
    """Return the shortest text that is this number in a script, which divides as Python does."""
    forms = [_NEEDLESS_ZERO.sub(r"\1", repr(value))]
    of_255 = round(255 * value) if abs(value) < 1 else 0
    if of_255 / 255 == value and value:
        forms.append(f"{of_255}/255")
    return min(forms, key=len)


def _write_key(key: str) -> str:
    return key if key.isidentifier() or key.isdecimal() else json.dumps(key)


def _list_keys(data: Any) -> Iterator[str]:
    """Yield the keys of data that are names of the program."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield key
            if key not in TABLES:
                yield from _list_keys(value)


def _list_texts(data: Any) -> Iterator[str]:
    """Yield the texts and keys of data."""
    if isinstance(data, str):
        yield data
    elif isinstance(data, dict | list):
        for item in data.values() if isinstance(data, dict) else data:
            yield from _list_texts(item)
