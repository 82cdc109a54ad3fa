"""The view of a picture: its size, and the matrix from the world to clip space."""

from dataclasses import dataclass

from .._core.types import Float64Array


@dataclass(frozen=True, eq=False)
class View:
    """What all drawables of a picture share.

    size : (width, height) in pixels
    clip_from_world : (4, 4), reversed-Z
    """

    size: tuple[int, int]
    clip_from_world: Float64Array


def ndc_to_pixels(ndc: Float64Array, size: tuple[int, int]) -> Float64Array:
    """Return x and y (..., 2) in pixels, from the picture's top left corner, of points (..., 2 or more) in NDC.

    It is the viewport transform of WebGPU; `clip_to_pixels` of the shaders is the same.
    """
    pixels: Float64Array = (ndc[..., :2] * (0.5, -0.5) + 0.5) * size
    return pixels
