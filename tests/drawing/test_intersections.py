"""Intersection lines in pictures: of layers, instances and parts of one mesh, with other edges, and refused without."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.drawing.intersections import MeetingLines, add_intersections
from gpu_xform.errors import MeshError
from gpu_xform.geometry.triangulation import triangulate
from tests.support.projection import world_to_pixels
from tests.support.types import Array

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
        assert (near.min(axis=0) < 160).mean() > 0.95
        assert 90 < (picture[..., 0] < 128).sum() < 500
        differs = np.abs(picture[..., 0].astype(int) - pictures[0][..., 0]) > 40
        assert differs.sum() < 10


def visible(points: Array, triangles: Array, eye: Array) -> Array:
    """Return which points (n, 3) of surfaces no triangle (t, 3, 3) hides from the eye: (n,) bool."""
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    ray = (points - eye)[:, None]
    across, beside = np.cross(ray, e2), np.cross(eye - a, e1)
    determinant = (e1 * across).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((eye - a) * across).sum(axis=-1) / determinant
        v = (ray * beside).sum(axis=-1) / determinant
        at = (e2 * beside).sum(axis=-1) / determinant
    hit = np.where((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0), at, np.inf)
    result: Array = hit.min(axis=1) > 0.9999
    return result


def bodies_that_meet(kind: str) -> tuple[list[Mesh], Array]:
    """Return two bodies, and points on the curve in which the ideal ones meet, that they stand for."""
    angle = np.linspace(0.0, 2.0 * np.pi, 241)
    cosine, sine = np.cos(angle), np.sin(angle)
    if kind == "spheres":
        ball = samples.icosphere(2)
        offset = np.array([1.0, 0.2, 0.3])
        radius = np.sqrt(1.0 - offset @ offset / 4.0)
        aside = np.cross(offset, (0, 1, 0)) / np.linalg.norm(np.cross(offset, (0, 1, 0)))
        up = np.cross(aside, offset) / np.linalg.norm(offset)
        circle = offset / 2.0 + radius * (cosine[:, None] * aside + sine[:, None] * up)
        return [ball, ball.transformed(matrices.translate(*offset))], circle
    n = 48
    ring = np.column_stack([np.cos(np.arange(n) * 2 * np.pi / n), np.sin(np.arange(n) * 2 * np.pi / n)])
    ends = np.concatenate([np.insert(0.8 * ring, 2, z, axis=1) for z in (-1.5, 1.5)])
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    tilt = 0.6
    plane = Mesh([(x, y, tilt * x) for x, y in ((-1.6, -1.6), (1.6, -1.6), (1.6, 1.6), (-1.6, 1.6))], [(0, 1, 2, 3)])
    ellipse = np.column_stack([0.8 * cosine, 0.8 * sine, tilt * 0.8 * cosine])
    return [Mesh(ends, [*sides, range(n), range(n, 2 * n)]), plane], ellipse


@pytest.mark.parametrize("kind", ["spheres", "cylinder"])
@pytest.mark.parametrize("eye", [(3.0, 2.0, 5.0), (-3.0, 1.0, 4.0), (1.0, -5.0, 2.0)])
def test_lines_have_no_gaps_where_they_are_seen(kind: str, eye: tuple[float, float, float]) -> None:
    bodies, curve = bodies_that_meet(kind)
    camera = Camera.look_at(eye, (0.3, 0, 0), fov_y=38.0)
    style: dict[str, Any] = {"edges": "intersection", "line_width": 2.0, "camera": camera, "size": (160, 160)}
    seen, all_ = (gx.render_array(bodies, hidden=h, **style)[..., 0].astype(int) for h in ("remove", "show"))
    lines = next(
        each.model
        for each in add_intersections([Layer(m, edges="intersection") for m in bodies])[1:]
        if isinstance(each, MeetingLines)
    )
    assert isinstance(lines, Mesh)
    along = np.linspace(0.02, 0.98, 12)[:, None, None]
    start, stop = lines.positions[lines.edges].transpose(1, 0, 2)
    points = (start * (1.0 - along) + stop * along).reshape(-1, 3)
    assert max(np.linalg.norm(curve - point, axis=1).min() for point in points[::7]) < 0.1
    triangles = [m.positions[triangulate(m.positions, m.offsets, m.indices)[0]] for m in bodies]
    points = points[visible(points, np.concatenate(triangles), np.array(eye))]
    x, y = np.floor(world_to_pixels(points, camera, (160, 160))).astype(int).T
    assert len(points) > 60
    assert (seen[y, x] - all_[y, x]).max() < 60
    assert (seen > 128).sum() > (all_ > 128).sum() + 15  # what is behind is hidden


def test_they_come_with_other_edges_and_under_a_fill() -> None:
    both = [Layer(BALL, edges=["silhouette", "intersection"], fill="gold"), Layer(BALL, fill="teal", transform=APART)]
    text = gx.render_svg(both, camera=CAMERA, size=SIZE)
    assert "intersection</title>" in text
    alone = gx.render_svg([both[0]], camera=CAMERA, size=SIZE)  # nothing to meet: the other edges alone
    assert "intersection" not in alone


def test_without_bodies_that_penetrate_there_is_nothing_to_draw() -> None:
    with pytest.raises(MeshError, match=r"^ball: edges must choose .*, 'intersection' chooses none: no two bodies"):
        gx.render_array(Layer(BALL, name="ball", edges="intersection"), size=SIZE)
