"""Small pictures of models and cameras, which notebooks show in place of a line of text."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.types import Float64Array
from ..drawing.camera import NEAR_FRACTION, Camera
from ..drawing.layer import Layer
from ..errors import GpuXformError
from ..geometry.mesh import Mesh
from ..matrices import inverse
from .raster import render

if TYPE_CHECKING:
    from PIL.Image import Image

SIZE = (320, 240)
MAX_POINTS = 100_000
CAMERA_ASPECT = 4.0 / 3.0
CORNERS = np.array([(x, y, z) for z in (0, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)  # near, then far
VOLUME_FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
AXIS_COLORS = ("#d62728", "#2ca02c", "#1f77b4")  # x, y, z
ASIDE = np.array([-0.8, -0.3, 0.5])  # along the right, the up and the view of the camera that is shown
NO_END = 1e-9  # of w beside the other coordinates, where a volume ends nowhere
AXIS_LENGTH = 0.25  # of the extent of the view volume


def draw_preview(thing: object) -> bytes | None:
    """Return a small PNG of a model or a camera; None if it cannot be drawn, as where there is no adapter."""
    try:
        picture = _draw_view_volume(thing) if isinstance(thing, Camera) else _draw_models(thing)
    except (GpuXformError, OSError):
        return None
    data = io.BytesIO()
    picture.convert("RGB").save(data, "PNG", optimize=True)
    return data.getvalue()


def _draw_models(models: Any) -> Image:
    if isinstance(models, Layer):
        return render(models, size=SIZE)
    return render(models, size=SIZE, hidden="remove", line_width="auto", max_points=MAX_POINTS)


def _draw_view_volume(camera: Camera) -> Image:
    """Draw what a camera sees as a frustum or a box, from its right, and the axes of the world at the origin.

    Of a camera that keeps no depths, as `Camera.window`, the window in the xy-plane is drawn alone.
    """
    corners = _unproject(camera, CORNERS)
    keeps_depths = camera.clip_from_world(CAMERA_ASPECT)[2, :3].any()
    faces = VOLUME_FACES if keeps_depths else VOLUME_FACES[:1]
    extent = float(np.ptp(corners[np.unique(faces)], axis=0).max())
    axes = [
        Layer(Mesh([(0, 0, 0), tip], [(0, 1)]), color=color, line_width=2.5)
        for tip, color in zip(AXIS_LENGTH * extent * np.eye(3), AXIS_COLORS, strict=True)
    ]
    ahead = _unit(corners[4:].mean(axis=0) - corners[:4].mean(axis=0))
    right, up = _unit(corners[5] - corners[4]), _unit(corners[6] - corners[4])
    seen_along = {"direction": ASIDE @ (right, up, ahead), "up": up}
    return render([Layer(Mesh(corners[: 8 if keeps_depths else 4], faces)), *axes], size=SIZE, camera=seen_along)


def _unit(vector: Float64Array) -> Float64Array:
    return vector / math.hypot(*vector)


def _unproject(camera: Camera, ndc: Float64Array) -> Float64Array:
    """Return points of the picture and its depths in the world; a volume without an end ends at a finite depth.

    Without depths, those of the picture lead from the xy-plane along -z.
    """
    clip_from_world = camera.clip_from_world(CAMERA_ASPECT)
    if not clip_from_world[2, :3].any():
        clip_from_world[2] = 0.0, 0.0, -1.0, 0.0
    world_from_clip = inverse(clip_from_world)
    end = world_from_clip @ (0.0, 0.0, 1.0, 1.0)
    depth = (
        1.0 if abs(end[3]) > NO_END * np.abs(end).max() else 1.0 - NEAR_FRACTION
    )  # as far as the plane of the window
    world = np.column_stack((ndc * (1.0, 1.0, depth), np.ones(len(ndc)))) @ world_from_clip.T
    return world[:, :3] / world[:, 3:]
