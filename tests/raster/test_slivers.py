"""Slivers: long, thin triangles cover together what the polygon covers that they are cut from."""

import numpy as np
import pytest

import gpu_xform as gx

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
