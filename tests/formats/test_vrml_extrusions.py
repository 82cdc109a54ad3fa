"""Extrusions computed together are those computed alone, and follow ISO 14772-1, 6.18."""

from pathlib import Path

import numpy as np
import pytest

from gpu_xform.formats import vrml
from gpu_xform.formats.vrml_extrusions import Extrusion, ExtrusionQueue, make_extrusion
from gpu_xform.matrices import rotate, translate
from tests.support.types import Array

SQUARE = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
ONE, UNTURNED = np.ones((1, 2)), np.array([[0.0, 0.0, 1.0, 0.0]])
SPINES = {
    "straight": [[0, 0, 0], [1, 1, 0], [2, 2, 0]],
    "up": [[0, 0, 0], [0, 1, 0]],
    "down": [[0, 0, 0], [0, -1, 0]],
    "a point": [[1, 2, 3], [1, 2, 3]],
    "a corner": [[0, 0, 0], [0, 4, 0], [4, 8, 0]],
    "a corner the other way": [[0, 0, 0], [0, 4, 0], [-4, 8, 0]],
    "a stair": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1], [2, 1, 1], [2, 2, 1]],
    "an S": [[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 2, 0], [4, 2, 0]],
    "a loop": [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [0, 0, 0]],
    "a stop on the way": [[0, 0, 0], [0, 0, 0], [1, 1, 0], [3, 0, 1]],
}


def sweep(*extrusions: Extrusion) -> list[Array]:
    queue, starts = ExtrusionQueue(), [0]
    for each in extrusions:
        queue.add(starts[-1], each, None)
        starts.append(starts[-1] + each.form.n_points)
    points = np.full((starts[-1], 3), np.nan)
    queue.fill(points)
    return np.split(points, starts[1:-1])


def test_many_are_what_each_is_alone() -> None:
    rng = np.random.default_rng(3)
    extrusions = []
    for spine in [*SPINES.values(), *SPINES.values()]:
        scales, turns = rng.uniform(0.5, 2, (len(spine), 2)), rng.normal(size=(2, 4))
        extrusions += [
            make_extrusion(SQUARE, np.array(spine, np.float64), ONE, UNTURNED),
            make_extrusion(SQUARE[:3] * rng.uniform(1, 2, 2), np.array(spine, np.float64), scales, turns),
        ]
    for together, extrusion in zip(sweep(*extrusions), extrusions, strict=True):
        assert np.allclose(together, sweep(extrusion)[0], rtol=0, atol=1e-14)


@pytest.mark.parametrize("spine", SPINES.values(), ids=SPINES)
def test_frames_are_right_handed_and_sections_stand_across_the_spine(spine: list[list[float]]) -> None:
    path = np.array(spine, np.float64)
    (points,) = sweep(make_extrusion(SQUARE, path, ONE, UNTURNED))
    n = len(points) // 4
    x, z = (points.reshape(n, 4, 3)[:, i] - path[:n] for i in (0, 1))  # corners (1, 1) and (1, -1)
    x, z = (x + z) / 2, (x - z) / 2
    assert np.allclose([np.linalg.norm(x, axis=1), np.linalg.norm(z, axis=1)], 1)
    y = np.cross(z, x)
    along = np.roll(path[:n], -1, axis=0) - np.roll(path[:n], 1, axis=0)
    if spine[0] != spine[-1]:
        along[0], along[-1] = path[1] - path[0], path[-1] - path[-2]
    assert ((y * along).sum(axis=1) >= np.linalg.norm(along, axis=1) * (1 - 1e-12)).all()
    assert ((z[1:] * z[:-1]).sum(axis=1) >= -1e-12).all()  # none is turned round


def test_orientations_turn_sections_and_the_last_stands_for_the_rest() -> None:
    spine = np.array([[0.0, 0, 0], [0, 1, 0], [0, 2, 0]])
    turns = np.array([[0.0, 0, 0, 0], [1, 2, 2, 0.5]])  # the first has no axis, and no angle
    (points,) = sweep(make_extrusion(SQUARE, spine, ONE, turns))
    flat = np.stack([SQUARE[:4, 0], np.zeros(4), SQUARE[:4, 1]], axis=1)
    turned = flat @ rotate((1, 2, 2), 0.5)[:3, :3].T
    assert np.allclose(points.reshape(3, 4, 3), np.stack([flat, turned, turned]) + spine[:, np.newaxis], atol=1e-14)


def test_each_goes_where_its_node_stands_and_as_its_transform_says() -> None:
    shapes = "".join(
        f"Transform {{ translation {i} 0 0 rotation 0 1 0 {i} children Shape {{ geometry Extrusion {{ }} }} }}"
        "Shape { geometry Box { } }"
        for i in range(3)
    )
    mesh = vrml.read(f"#VRML V2.0 utf8\n{shapes}Shape {{ geometry Extrusion {{ ccw FALSE }} }}".encode(), Path())
    one = vrml.read(b"#VRML V2.0 utf8\nShape { geometry Extrusion { } }", Path())
    for i in range(3):
        moved = one.transformed(translate(i, 0, 0) @ rotate((0, 1, 0), i))
        assert np.allclose(mesh.positions[16 * i : 16 * i + 8], moved.positions, atol=1e-14)
    assert np.array_equal(mesh.positions[48:], one.positions)
    assert mesh.n_faces == 3 * 12 + 6
