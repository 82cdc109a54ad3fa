"""Where points of the world and of clip space lie in a picture, in pixels from its top left corner."""

import numpy as np

from gpu_xform import Camera
from gpu_xform.drawing.view import ndc_to_pixels
from tests.support.types import Array


def clip_to_pixels(clip: Array, size: tuple[int, int]) -> Array:
    """Return the pixel coordinates (..., 2) of points in clip space (..., 4)."""
    return ndc_to_pixels(clip[..., :2] / clip[..., 3:], size)


def world_to_clip(positions: Array, camera: Camera, size: tuple[int, int]) -> Array:
    """Return points of the world (n, 3) in clip space: (n, 4)."""
    clip: Array = np.column_stack([positions, np.ones(len(positions))]) @ camera.clip_from_world(size[0] / size[1]).T
    return clip


def world_to_pixels(positions: Array, camera: Camera, size: tuple[int, int]) -> Array:
    """Return the pixel coordinates (n, 2) of points of the world (n, 3)."""
    return clip_to_pixels(world_to_clip(positions, camera, size), size)
