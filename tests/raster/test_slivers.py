"""Slivers: long, thin triangles cover together what the polygon covers that they are cut from."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform import samples
from gpu_xform.raster import triangles

CAMERAS = {
    "parallel": gx.Camera.fit([(-5, -3, 0), (5, 3, 0)], direction=(-1, 1, -1), up=(0, 0, 1), orthographic=True),
    "perspective": gx.Camera.look_at((4, -6, 3), (0, 0, 0), (0, 0, 1)),
    "around the eye": gx.Camera.look_at((0.3, 0.2, 0.05), (-1, 0.5, 0), (0, 0, 1), near=0.001, far=100.0),
}


@pytest.mark.parametrize("camera", CAMERAS)
def test_slivers_cover_what_their_polygon_covers(camera: str) -> None:
    sides = np.linspace((5, -3, 0), (5, 3, 0), 200), np.linspace((5, 3, 0), (-5, 3, 0), 200)
    points = np.concatenate([[(-5, -3, 0)], *sides])
    fan = gx.Mesh(points, [(0, i, i + 1) for i in range(1, len(points) - 1)])
    whole = gx.Mesh([(-5, -3, 0), (5, -3, 0), (5, 3, 0), (-5, 3, 0)], [(0, 1, 2, 3)])
    ours, expected = (
        gx.render_array(mesh, camera=CAMERAS[camera], size=(700, 600), fill="gold", color=(0, 0, 0, 0))
        for mesh in (fan, whole)
    )
    assert (expected[..., 2] < 128).mean() > 0.1
    assert (ours != expected).any(axis=2).mean() < 1e-4


@pytest.mark.parametrize("style", [{}, {"fill": "gold"}, {"fill": "gold", "depth_cue": 0.5, "shading": "smooth"}])
def test_triangles_that_are_drawn_apart_change_no_byte(style: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    turns = np.linspace(0.0, 2.0 * np.pi, 40)
    rim = np.stack([3.0 * np.cos(turns), np.sin(turns), 0.2 * np.sin(3.0 * turns)], axis=1)
    fan = gx.Mesh([(2.9, 0.0, 0.0), *rim], [(0, i, i + 1) for i in range(1, 40)])  # large ones and slivers
    models = [gx.Layer(fan, transform=stack(), **style), gx.Layer(samples.icosphere(4), transform=stack(), **style)]
    pictures = []
    for least in (1, 1 << 40):
        monkeypatch.setattr(triangles, "MIN_TRIANGLES_APART", least)
        pictures.append(gx.render_array(models, size=(400, 200), hidden="remove"))
    assert len(np.unique(pictures[0].reshape(-1, 4), axis=0)) > 3
    assert pictures[0].tobytes() == pictures[1].tobytes()


def stack() -> npt.NDArray[np.float64]:
    """Return two places of a model."""
    return np.stack([gx.translate(-1.5, 0.0, 0.0) @ gx.scale(0.5), gx.translate(0.5, 0.3, 0.1)])
