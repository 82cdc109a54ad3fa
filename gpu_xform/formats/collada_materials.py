"""Materials of COLLADA files: the colour of each."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import MeshError
from ._text import quote
from .collada_geometries import as_bytes, first_child

_SHADERS = ("phong", "lambert", "blinn", "constant")
_WHITE = (1.0, 1.0, 1.0, 1.0)


def find_effect(material: Any, effects: dict[str | None, Any]) -> Any:
    """Return the effect of a material, of those of the file; raise MeshError if it is not there."""
    instance = first_child(material, "instance_effect")
    url = "" if instance is None else instance.get("url") or ""
    effect = effects.get(url[1:]) if url.startswith("#") else None
    if effect is None:
        raise MeshError(f"there is no effect {quote(url)}")
    return effect


def read_color(effect: Any) -> npt.NDArray[np.uint8]:
    """Return the diffuse colour of an effect, white for a texture, with the alpha of what makes it transparent: (4,).

    Raises MeshError for what is damaged.
    """
    profile = first_child(effect, "profile_COMMON")
    technique = None if profile is None else first_child(profile, "technique")
    if technique is None:
        raise MeshError("its effect has no technique")
    shader = next((found for name in _SHADERS if (found := first_child(technique, name)) is not None), None)
    if shader is None:
        raise MeshError("its effect has no shader")
    scopes = (technique, profile)
    color = _read_property(shader, "diffuse", scopes) or _WHITE
    transparent = _read_property(shader, "transparent", scopes)
    if transparent is not None:
        color = (*color[:3], transparent[3])
    return as_bytes(np.array([color])).ravel()


def _read_property(shader: Any, name: str, scopes: tuple[Any, ...]) -> tuple[float, ...] | None:
    """Return a property of a shader that is a colour, as four floats; None for a texture, and for none."""
    found = first_child(shader, name)
    value = None if found is None else next(found.iterchildren("{*}*"), None)
    if value is not None and _local_name(value) == "param":
        value = _find_parameter(value.get("ref"), scopes)
    if value is None or _local_name(value) not in ("color", "float3", "float4"):
        return None
    try:
        numbers = [float(word) for word in (value.text or "").split()]
    except ValueError:
        numbers = []
    if not 1 <= len(numbers) <= 4:
        raise MeshError(f"its {name} colour must be 3 or 4 numbers, got {quote(value.text or '')}")
    numbers += [0.0] * (3 - len(numbers))
    return (*numbers[:3], numbers[3] if len(numbers) == 4 else 1.0)


def _find_parameter(name: str | None, scopes: tuple[Any, ...]) -> Any:
    """Return what a parameter of an effect holds, or None."""
    for scope in scopes:
        for parameter in scope.iterchildren("{*}newparam"):
            if parameter.get("sid") == name:
                return next(parameter.iterchildren("{*}float3", "{*}float4"), None)
    return None


def _local_name(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]
