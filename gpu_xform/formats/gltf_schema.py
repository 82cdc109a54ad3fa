"""What is wrong with the JSON of a glTF document that could not be read: where, what must be there, and what came.

A table of what the readers look at, in place of the schema of the glTF 2.0 specification, which is much larger.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from ._text import quote
from .gltf_accessors import DTYPES, MESHOPT, N_COMPONENTS


@dataclass(frozen=True)
class _Index:
    """An index of an array of the document."""

    of: str


# A word for a simple value, an index, the values that there may be, [what an array holds], or what an object holds by
# name: "name!" must be there, and "*" stands for all.
_Rule: TypeAlias = "str | _Index | tuple[Any, ...] | list[_Rule] | dict[str, _Rule]"

_TEXT, _NUMBER, _COUNT = "a text", "a number", "an integer of at least 0"
_NUMBERS: _Rule = [_NUMBER]
_ACCESSOR, _VIEW, _BUFFER, _NODE = map(_Index, ("accessors", "bufferViews", "buffers", "nodes"))
_NAMED: _Rule = {"*": _ACCESSOR}
_TYPES = tuple(DTYPES)
_SLICE: dict[str, _Rule] = {"buffer!": _BUFFER, "byteOffset": _COUNT, "byteLength!": _COUNT, "byteStride": _COUNT}
_PRIMITIVE: _Rule = {
    "attributes!": _NAMED,
    "indices": _ACCESSOR,
    "material": _Index("materials"),
    "mode": _COUNT,
    "targets": [_NAMED],
    "extensions": {"KHR_draco_mesh_compression": {"bufferView!": _VIEW, "attributes!": {"*": _COUNT}}},
}
_DOCUMENT: _Rule = {
    "buffers": [{"byteLength!": _COUNT, "uri": _TEXT}],
    "bufferViews": [{**_SLICE, "extensions": {MESHOPT: {**_SLICE, "count!": _COUNT, "mode!": _TEXT}}}],
    "accessors": [
        {
            "bufferView": _VIEW,
            "byteOffset": _COUNT,
            "componentType!": _TYPES,
            "count!": _COUNT,
            "type!": tuple(N_COMPONENTS),
            "sparse": {
                "count!": _COUNT,
                "indices!": {"bufferView!": _VIEW, "componentType!": _TYPES},
                "values!": {"bufferView!": _VIEW},
            },
        }
    ],
    "meshes": [{"name": _TEXT, "primitives!": [_PRIMITIVE], "weights": _NUMBERS}],
    "skins": [{"joints!": [_NODE], "inverseBindMatrices": _ACCESSOR}],
    "nodes": [
        {
            "name": _TEXT,
            "children": [_NODE],
            "mesh": _Index("meshes"),
            "skin": _Index("skins"),
            **dict.fromkeys(("matrix", "translation", "rotation", "scale", "weights"), _NUMBERS),
            "extensions": {"KHR_node_visibility": {}, "EXT_mesh_gpu_instancing": {"attributes!": _NAMED}},
        }
    ],
    "scenes": [{"nodes": [_NODE]}],
    "scene": _Index("scenes"),
    "animations": [
        {
            "name": _TEXT,
            "channels!": [{"sampler!": _COUNT, "target!": {"node": _NODE, "path!": _TEXT}}],
            "samplers!": [{"input!": _ACCESSOR, "output!": _ACCESSOR, "interpolation": _TEXT}],
        }
    ],
    "materials": [{"name": _TEXT, "pbrMetallicRoughness": {"baseColorFactor": _NUMBERS}, "extensions": {}}],
    "images": [{"uri": _TEXT, "bufferView": _VIEW, "mimeType": _TEXT}],
    "textures": [{}],
    "samplers": [{}],
    "cameras": [{}],
    "asset": {},
    "extensions": {},
    "extensionsUsed": [_TEXT],
    "extensionsRequired": [_TEXT],
}


def explain(content: Any) -> str:
    """Return what is wrong with the JSON of a document that could not be read."""
    return next(_find(content, _DOCUMENT, "", content), "a value in it contradicts others")


def _find(value: Any, rule: _Rule, place: str, content: Any) -> Iterator[str]:
    """Yield what is wrong with a value, and within it."""
    if isinstance(rule, dict):
        if not isinstance(value, Mapping):
            yield _describe(value, place, "an object")
            return
        for name, each in rule.items():
            key = name.removesuffix("!")
            if key == "*":
                for own, held in value.items():
                    yield from _find(held, each, f"{place}.{own}", content)
            elif key in value:
                yield from _find(value[key], each, f"{place}.{key}", content)
            elif key != name:
                yield f"{_name(place)} has no {key}"
    elif isinstance(rule, list):
        if not isinstance(value, list):
            yield _describe(value, place, "an array")
            return
        for i, held in enumerate(value):
            yield from _find(held, rule[0], f"{place}[{i}]", content)
    elif isinstance(rule, _Index):
        held = content.get(rule.of, ())
        n = len(held) if isinstance(held, list) else 0
        if not _is_count(value) or value >= n:
            yield _describe(value, place, f"an index of {rule.of}, of which there are {n}")
    elif isinstance(rule, tuple):
        if not any(type(value) is type(allowed) and value == allowed for allowed in rule):
            yield _describe(value, place, f"one of {', '.join(map(str, rule))}")
    elif not _IS[rule](value):
        yield _describe(value, place, rule)


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


_IS = {
    _TEXT: lambda value: isinstance(value, str),
    _NUMBER: lambda value: type(value) in (int, float),
    _COUNT: _is_count,
}


def _describe(value: Any, place: str, expected: str) -> str:
    kinds = {list: "an array", dict: "an object", type(None): "null", bool: str(value).lower()}
    got = kinds.get(type(value)) or quote(value if isinstance(value, str) else repr(value))
    return f"{_name(place)} must be {expected}, got {got}"


def _name(place: str) -> str:
    return quote(place.removeprefix(".")) if place else "it"
