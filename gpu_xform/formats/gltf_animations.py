"""The animations of a glTF document (3.11). Section numbers are those of the glTF 2.0 specification."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.scene_animation import Channel, Interpolation, Placement, Property, SceneAnimation
from ._text import quote
from ._warn import warn
from .gltf_accessors import Accessors, get_count
from .gltf_placements import make_names, read_placement
from .limits import budget

_TYPES = {"translation": ("VEC3", 3), "rotation": ("VEC4", 4), "scale": ("VEC3", 3), "weights": ("SCALAR", 1)}
_INTERPOLATIONS = ("STEP", "LINEAR", "CUBICSPLINE")


class _Source(NamedTuple):
    """Where the keyframes of a property are."""

    path: str
    input: int
    output: int
    interpolation: str

    @classmethod
    def of(cls, path: str, sampler: Any) -> "_Source":
        """Return that of a sampler."""
        interpolation = sampler.get("interpolation", "LINEAR")
        if interpolation not in _INTERPOLATIONS:
            raise MeshError(f"its interpolation must be one of {', '.join(_INTERPOLATIONS)}, got {interpolation!r}")
        return cls(path, get_count(sampler, "input"), get_count(sampler, "output"), interpolation)


def read_animations(
    document: Any, names: Sequence[str], shown: Mapping[str, int], accessors: Accessors
) -> list[SceneAnimation]:
    """Return the animations of nodes; what cannot be read of them is left out, and named in a MeshWarning.

    names : of all nodes
    shown : the nodes that the scene holds, by name
    """
    animations = document.get("animations", [])
    keyframes = dict[_Source, Channel]()  # what several nodes share
    found = []
    for i, name in enumerate(make_names([animation.get("name") for animation in animations], "animation")):
        channels: dict[tuple[str, str], Channel] = {}
        placements: dict[str, Placement] = {}
        for c, channel in enumerate(animations[i]["channels"]):
            target = channel["target"]
            if "node" not in target and "extensions" not in target:  # to be ignored (3.11)
                continue
            try:
                path = target["path"]
                if path not in _TYPES:
                    raise MeshError(f"it moves {quote(str(path))}, which is none of {', '.join(_TYPES)}")
                node = get_count(target, "node")
                if names[node] not in shown:
                    continue
                if path != "weights":
                    if "matrix" in document["nodes"][node]:
                        raise MeshError(f"node {node} has a matrix, not the property that moves")
                    placements[names[node]] = read_placement(document["nodes"][node])
                sampler = animations[i]["samplers"][get_count(channel, "sampler")]
                source = _Source.of(path, sampler)
                if source not in keyframes:
                    keyframes[source] = _read_channel(names[node], source, accessors)
                channels[names[node], path] = replace(keyframes[source], node=names[node])
            except (ArgumentError, ArgumentTypeError, MeshError) as error:
                if budget().is_spent:
                    raise
                warn(f"animation {name!r} misses its channel {c}, which cannot be read: {error}")
        if channels:
            found.append(SceneAnimation(name, tuple(channels.values()), placements))
    return found


def _read_channel(node: str, source: _Source, accessors: Accessors) -> Channel:
    """Return the keyframes of a property of a node."""
    path, interpolation = source.path, source.interpolation
    kind, width = _TYPES[path]
    n_values = accessors.count(source.input) + width * accessors.count(source.output)
    budget().take_values(n_values, "the keyframes of its animations")
    times = accessors.floats(source.input, "SCALAR")[:, 0]
    values = accessors.floats(source.output, kind)
    if len(times) == 0 or not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise MeshError("its times must ascend")
    if not np.isfinite(values).all():
        raise MeshError("its values must be finite")
    parts = 3 if interpolation == "CUBICSPLINE" else 1
    columns = values.size // (len(times) * parts) if path == "weights" else width
    if values.size != len(times) * parts * columns or columns == 0:
        raise MeshError(f"it has {len(values)} values for {len(times)} times")
    keyframes = values.reshape(len(times), parts, columns)
    middle: Float64Array = keyframes[:, parts // 2]
    if path == "rotation" and not np.linalg.norm(middle, axis=1).all():
        raise MeshError("a rotation of its is zero")
    tangents = (keyframes[:, 0], keyframes[:, 2]) if parts == 3 else (None, None)
    return Channel(
        node, cast("Property", path), times, middle, cast("Interpolation", interpolation), tangents[0], tangents[1]
    )
