"""Framing: what decides where a camera stands, and how precisely points are kept, is what is shown."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx

SIZE = (200, 150)
HOUSE = gx.samples.house()
FAR = [[1e4, -2e4, 3e3], [0.0, 0.0, 0.0], [1e300, 0.0, 0.0]]
POINTS = np.array([[0.0, 0, 0], [1, 2, 3], [50, 60, 70]])
Pixels = npt.NDArray[np.uint8]


def with_strays(mesh: gx.Mesh, strays: Any = FAR) -> gx.Mesh:
    """Return the mesh with points before its own that no face uses."""
    n = len(strays)
    return gx.Mesh(np.vstack([strays, mesh.positions]), [[int(i) + n for i in face] for face in mesh.faces])


def draw(mesh: gx.Mesh, **style: Any) -> Pixels:
    return gx.render_array(mesh, size=SIZE, **style)


@pytest.mark.parametrize(
    "style",
    [
        {},
        {"hidden": "remove"},
        {"edges": ["feature", "silhouette"], "hidden": "dash"},
        {"fill": "face", "depth_cue": 0.7},
        {"transform": np.stack([gx.translate(0, 0, 0), gx.translate(4, 1, -2)])},
    ],
    ids=str,
)
@pytest.mark.parametrize("orthographic", [False, True])
def test_points_that_no_face_uses_change_nothing(style: dict[str, Any], orthographic: bool) -> None:
    house = HOUSE.transformed(gx.chain(gx.scale(3), gx.translate(512345, 101, -4512345)))
    camera = {"orthographic": orthographic}
    assert np.array_equal(draw(with_strays(house), camera=camera, **style), draw(house, camera=camera, **style))


def test_points_that_no_face_uses_do_not_move_the_axis_of_a_turntable() -> None:
    turning, expected = gx.turntable(with_strays(HOUSE), 3, size=SIZE), gx.turntable(HOUSE, 3, size=SIZE)
    for one, other in zip(turning, expected, strict=True):
        assert np.array_equal(np.asarray(one), np.asarray(other))


def test_points_of_edges_that_are_given_count() -> None:
    mesh = with_strays(HOUSE, [[9.0, 0.0, 0.0], [9.0, 5.0, 0.0], [500.0, 0.0, 0.0]])
    shown = draw(mesh, edges=[np.array([[0, 1]]), "all"])
    faces = [[0, 1], *[[int(i) + 2 for i in face] for face in HOUSE.faces]]
    assert np.array_equal(shown, draw(gx.Mesh(mesh.positions[[0, 1, *range(3, mesh.n_points)]], faces)))
    cloud, both = gx.Mesh(POINTS), gx.Mesh(POINTS[:2])
    assert np.array_equal(draw(cloud, edges=[[0, 1]]), draw(both, edges=[[0, 1]]))


def test_points_that_are_drawn_count() -> None:
    is_dark = draw(with_strays(HOUSE, [[9.0, 0.0, 0.0]]), point_size=9.0)[..., 0] < 128
    assert np.flatnonzero(is_dark.any(axis=0)).max() > 180  # the dot of the stray point is in the picture


def test_all_points_of_a_cloud_count() -> None:
    assert np.array_equal(gx.Mesh(POINTS).used_positions, POINTS)
    assert np.array_equal(gx.Mesh(POINTS, [[0, 1]]).used_positions, POINTS[:2])
