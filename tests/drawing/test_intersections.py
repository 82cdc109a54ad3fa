"""Intersection lines in pictures: of layers, instances and parts of one mesh, with other edges, and refused without."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.errors import MeshError
from tests.support.projection import world_to_pixels

SIZE = (120, 120)
CAMERA = Camera.look_at((0, 0, 6), (0, 0, 0), fov_y=30.0)
BALL = samples.icosphere(3)
APART = matrices.translate(1.0, 0, 0)
CIRCLE = np.array([(0.5, y, np.sqrt(max(0.75 - y * y, 0.0))) for y in np.linspace(-0.8, 0.8, 81)])


def test_layers_instances_and_parts_of_a_mesh_meet_alike() -> None:
    style: dict[str, Any] = {"edges": "intersection", "hidden": "remove", "line_width": 2.0}
    parts = Mesh(
        np.concatenate([BALL.positions, BALL.transformed(APART).positions]),
        [*BALL.faces, *(np.add(face, BALL.n_points) for face in BALL.faces)],
    )
    layers = [Layer(BALL, **style), Layer(BALL, transform=APART, **style)]
    instances = Layer(BALL, transform=np.stack([np.eye(4), APART]), **style)
    each: list[Any] = [layers, instances, Layer(parts, **style)]
    pictures = [gx.render_array(models, camera=CAMERA, size=SIZE) for models in each]
    for picture in pictures:
        x, y = np.floor(world_to_pixels(CIRCLE, CAMERA, SIZE)).astype(int).T
        near = np.stack([picture[y, x + aside, 0] for aside in (-1, 0, 1)])  # facets lie within the spheres
        assert (near.min(axis=0) < 160).mean() > 0.85  # in the crease, faces hide a pixel here and there
        assert 90 < (picture[..., 0] < 128).sum() < 500
        differs = np.abs(picture[..., 0].astype(int) - pictures[0][..., 0]) > 40
        assert differs.sum() < 10


def test_they_come_with_other_edges_and_under_a_fill() -> None:
    both = [Layer(BALL, edges=["silhouette", "intersection"], fill="gold"), Layer(BALL, fill="teal", transform=APART)]
    text = gx.render_svg(both, camera=CAMERA, size=SIZE)
    assert "intersection</title>" in text
    alone = gx.render_svg([both[0]], camera=CAMERA, size=SIZE)  # nothing to meet: the other edges alone
    assert "intersection" not in alone


def test_without_bodies_that_penetrate_there_is_nothing_to_draw() -> None:
    with pytest.raises(MeshError, match=r"^ball: edges must choose .*, 'intersection' chooses none: no two bodies"):
        gx.render_array(Layer(BALL, name="ball", edges="intersection"), size=SIZE)
