"""The sRGB transfer function, both ways: encoded values, and light.

Source: IEC 61966-2-1.
"""

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from .pixels import N_RGBA, RGB


def decode(pixels: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return light from 0 to 1 for pixels (k, h, w, c), whose fourth channel is alpha if there are four.

    uint8 becomes float32, uint16 float64; floats stay what they are.
    """
    if pixels.dtype.kind == "f":
        decoded = pixels.copy()
        colors = decoded[..., RGB] if pixels.shape[-1] == N_RGBA else decoded
        colors[...] = _to_light(colors)
        return decoded
    light: npt.NDArray[Any] = _light_of_integers(pixels.dtype.str)[pixels]
    if pixels.shape[-1] == N_RGBA:
        light[..., 3] = pixels[..., 3] / light.dtype.type(np.iinfo(pixels.dtype).max)
    return light


def encode(light: npt.NDArray[Any], out: npt.NDArray[Any]) -> None:
    """Write what `decode` made light of into `out`; integers are rounded to the nearest and clamped."""
    if out.dtype.kind == "f":
        out[...] = light
        colors = out[..., RGB] if out.shape[-1] == N_RGBA else out
        colors[...] = _from_light(colors)
        return
    out[...] = np.searchsorted(_steps_between_integers(out.dtype.str), light)
    if out.shape[-1] == N_RGBA:
        largest = np.iinfo(out.dtype).max
        out[..., 3] = np.rint(np.clip(light[..., 3], 0.0, 1.0) * largest)


def _to_light(encoded: npt.NDArray[Any]) -> npt.NDArray[Any]:
    bent = ((np.maximum(encoded, 0.04045) + 0.055) / 1.055) ** 2.4
    return np.asarray(np.where(encoded <= 0.04045, encoded / 12.92, bent), encoded.dtype)


def _from_light(light: npt.NDArray[Any]) -> npt.NDArray[Any]:
    bent = 1.055 * np.maximum(light, 0.0031308) ** (1.0 / 2.4) - 0.055
    return np.asarray(np.where(light <= 0.0031308, light * 12.92, bent), light.dtype)


@functools.cache
def _light_of_integers(dtype: str) -> npt.NDArray[Any]:
    largest = np.iinfo(dtype).max
    return _to_light(np.arange(largest + 1) / largest).astype(np.float32 if largest == 255 else np.float64)


@functools.cache
def _steps_between_integers(dtype: str) -> Float64Array:
    largest = np.iinfo(dtype).max
    return np.asarray(_to_light((np.arange(largest) + 0.5) / largest), np.float64)
