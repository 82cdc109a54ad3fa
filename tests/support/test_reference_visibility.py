"""Reference visibility against answers by hand, convex solids, and rays cast one by one."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import (
    Camera,
    Mesh,
    chain,
    orthographic,
    perspective,
    rotate_x,
    rotate_y,
    rotate_z,
    samples,
    scale,
    translate,
)
from gpu_xform.geometry.edges import compute_face_normals, find_edge_faces
from tests.support.projection import clip_to_pixels
from tests.support.reference_visibility import MIN_PART, clip_to_view, gaps, visible_intervals
from tests.support.solids import box, center, concatenate, interlocking, l_prism, staircase, star_prism, thin_plates
from tests.support.types import Array

FROM_ABOVE = orthographic(-10, 10, -10, 10, -10, 10)  # the xy-plane, seen against z


def square(low: tuple[float, float], high: tuple[float, float], z: float) -> Mesh:
    (x0, y0), (x1, y1) = low, high
    return Mesh([(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)], [(0, 1, 2, 3)])


def segment(a: npt.ArrayLike, b: npt.ArrayLike) -> Mesh:
    return Mesh(np.array([a, b]), [(0, 1)])


def assert_seen(mesh: Mesh, edge: tuple[int, int], clip_from_model: Array, expected: npt.ArrayLike) -> None:
    for ends, parts in ((edge, np.asarray(expected)), (edge[::-1], 1.0 - np.asarray(expected)[::-1, ::-1])):
        (seen,) = visible_intervals(mesh, np.array([ends]), clip_from_model)
        assert seen.shape == parts.shape
        assert seen == pytest.approx(parts, abs=1e-8)


NOTHING = np.empty((0, 2))


def test_of_two_overlapping_squares_the_front_one_is_whole() -> None:
    mesh = concatenate(square((0, 0), (4, 2), 1.0), square((1, -1), (6, 1.5), 0.0))
    for edge in ((0, 1), (1, 2), (2, 3), (3, 0)):
        assert_seen(mesh, edge, FROM_ABOVE, [(0, 1)])
    assert_seen(mesh, (4, 5), FROM_ABOVE, [(0, 1)])
    assert_seen(mesh, (5, 6), FROM_ABOVE, [(0, 1)])
    assert_seen(mesh, (6, 7), FROM_ABOVE, [(0, 2 / 5)])
    assert_seen(mesh, (7, 4), FROM_ABOVE, [(1.5 / 2.5, 1)])


def test_a_line_passes_behind_two_faces_and_over_a_third() -> None:
    mesh = concatenate(
        segment((-8, 0, 0), (8, 0, 0)),
        square((-6, -1), (-3, 2), 0.5),
        square((-1, -1), (3, 1), -0.5),
        square((4, -2), (5, 1), 2.0),
    )
    assert_seen(mesh, (0, 1), FROM_ABOVE, [(0, 2 / 16), (5 / 16, 12 / 16), (13 / 16, 1)])


def test_a_line_through_a_face_is_hidden_behind_it() -> None:
    mesh = concatenate(segment((-2, 0, -1), (6, 0, 3)), square((-4, -1), (4, 1), 0.0))
    assert_seen(mesh, (0, 1), FROM_ABOVE, [(2 / 8, 1)])


def test_a_line_in_the_plane_of_a_face_is_not_hidden_by_it() -> None:
    turn = rotate_x(0.4) @ rotate_y(1.1)
    mesh = concatenate(segment((-8, 0.3, 0), (8, -0.2, 0)), square((-1, -1), (2, 1), 0.0)).transformed(turn)
    assert_seen(mesh, (0, 1), FROM_ABOVE, [(0, 1)])
    assert_seen(mesh, (0, 1), FROM_ABOVE @ rotate_y(math.pi), [(0, 1)])


@pytest.mark.parametrize("turn", np.linspace(0.0, 3.0, 13))
def test_nothing_shows_through_the_seam_between_two_triangles(turn: float) -> None:
    mesh = concatenate(segment((-2, -1, -3), (4, 2, -1)), square((-1, -0.5), (3, 1.5), 0.0))  # along the diagonal
    assert_seen(mesh.transformed(rotate_z(turn)), (0, 1), FROM_ABOVE, [(0, 1 / 6), (5 / 6, 1)])


@pytest.mark.parametrize("turn", np.linspace(0.0, 3.0, 13))
def test_a_face_that_only_touches_a_line_in_the_picture_hides_nothing_of_it(turn: float) -> None:
    corner = Mesh([(0.3, 0, 1), (2, 1, 1), (-1, 1, 1)], [(0, 1, 2)])
    mesh = concatenate(segment((-2, 0, 0), (3, 0, 0)), corner).transformed(rotate_z(turn))
    assert_seen(mesh, (0, 1), FROM_ABOVE, [(0, 1)])


@pytest.mark.parametrize("turn", np.linspace(0.0, 3.0, 13))
def test_nothing_shows_where_many_faces_meet(turn: float) -> None:
    around = [(math.cos(a), math.sin(a), 1.0) for a in np.arange(7) * math.tau / 7]
    fan = Mesh([(0, 0, 1), *around], [(0, 1 + i, 1 + (i + 1) % 7) for i in range(7)])
    mesh = concatenate(segment((-0.6, 0, 0), (0.5, 0, 0)), fan).transformed(rotate_z(turn))
    assert_seen(mesh, (0, 1), FROM_ABOVE, NOTHING)


def test_parts_are_measured_in_the_picture_and_not_in_space() -> None:
    eye_at_0 = perspective(90, 1, 0.5, 100)
    # In the picture it runs from x = -1/2 to 1/2, and the face to the right of x = 0.1 hides a third of it from sight.
    mesh = concatenate(segment((-1, 0, -2), (4, 0, -8)), square((0.1, -1), (0.3, 1), -1.0))
    assert_seen(mesh, (0, 1), eye_at_0, [(0, 0.6), (0.8, 1)])


def test_edges_are_clipped_to_the_view() -> None:
    camera = perspective(90, 1, 1, 10)
    mesh = concatenate(
        segment((-30, 0, -6), (3, 0, -6)), segment((0, 0.5, 5), (0, 0.5, -30)), segment((0, 9, -3), (1, 9, -3))
    )
    view = clip_to_view(mesh, np.array([(0, 1), (2, 3), (4, 5)]), camera)
    assert view.between[:2] == pytest.approx(np.array([(24 / 33, 1), (6 / 35, 15 / 35)]))
    assert np.isnan(view.between[2]).all()
    ends = clip_to_pixels(view.clip, (200, 100))
    assert ends[:2] == pytest.approx(np.array([[(0, 50), (150, 50)], [(100, 25), (100, 47.5)]]))
    hidden = concatenate(mesh, square((-0.75, -1), (0, 1), -1.5))  # in the picture from -1/2 to 0
    seen = visible_intervals(hidden, np.array([(0, 1), (2, 3), (4, 5)]), camera)
    assert seen[0] == pytest.approx(np.array([(0, 0.5 / 1.5), (1 / 1.5, 1)]), abs=1e-8)
    assert len(seen[2]) == 0


def test_a_face_before_the_near_plane_hides_nothing_and_one_across_it_from_there_on() -> None:
    camera = perspective(90, 1, 1, 100)
    line = segment((-4, 0, -5), (4, 0, -5))
    assert_seen(concatenate(line, square((-1, -1), (1, 1), -0.9)), (0, 1), camera, [(0, 1)])
    assert_seen(concatenate(line, square((-1, -1), (1, 1), -1.25)), (0, 1), camera, NOTHING)
    # In the plane x = -1 - z, as far as z = -3: it meets the near plane at x = 0, and ends at 2/3 in the picture.
    for z in (-0.5, 0.0, 1.0):
        across = Mesh([(-1 - z, -9, z), (2, -9, -3), (2, 9, -3), (-1 - z, 9, z)], [(0, 1, 2, 3)])
        assert_seen(concatenate(line, across), (0, 1), camera, [(0, 0.5), ((2 / 3 + 0.8) / 1.6, 1)])


def test_an_edge_seen_end_on_has_no_parts() -> None:
    assert_seen(segment((1, 2, -3), (1, 2, 4)), (0, 1), FROM_ABOVE, NOTHING)


def test_a_matrix_without_depth_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        visible_intervals(samples.cube(), samples.cube().edges, Camera.window((-1, 1), (-1, 1)).clip_from_world(1.0))


def test_the_leg_of_an_l_hides_a_part_of_its_notch() -> None:
    # From x = 3, a little from y = 0 and from above: to the right y + x / 10, upwards z - x / 10, and x comes closer.
    clip_from_model = np.array([[0.01, 0.1, 0, 0], [-0.01, 0, 0.1, 0], [-0.1, 0, 0, 0.5], [0, 0, 0, 1.0]])
    mesh = l_prism()  # corners 0 to 5 below, 6 to 11 above
    hidden = {(2, 3), (4, 5), (0, 5), (3, 9), (5, 11)}
    for edge in map(tuple, mesh.edges.tolist()):
        if edge == (3, 4):  # from y = 1 to 2, at x = 1; the leg in front of it ends at y = 1, x = 3
            assert_seen(mesh, edge, clip_from_model, [(0.2, 1)])
        else:
            assert_seen(mesh, edge, clip_from_model, NOTHING if edge in hidden else [(0, 1)])


@pytest.mark.parametrize("orthographic_view", [False, True])
@pytest.mark.parametrize(
    "solid", [samples.cube(), samples.house(), samples.snub_dodecahedron(), samples.icosphere(2)], ids=repr
)
def test_an_edge_of_a_convex_solid_is_seen_where_one_of_its_faces_looks_at_the_eye(
    solid: Mesh, orthographic_view: bool
) -> None:
    eye = np.array([2.3, -3.1, 6.7])
    camera = Camera.look_at(eye, (0, 0, 0), fov_y=50, orthographic=orthographic_view)
    clip_from_model = camera.clip_from_world(1.3)
    found = find_edge_faces(solid)
    towards = eye - (0.0 if orthographic_view else solid.positions[[face[0] for face in solid.faces]])
    lit = np.einsum("ij,ij->i", compute_face_normals(solid), np.broadcast_to(towards, (solid.n_faces, 3))) > 0.0
    expected = lit[found.faces].any(axis=1)
    seen = visible_intervals(solid, found.edges, clip_from_model)
    assert 0.3 < expected.mean() < 0.8
    for parts, whole in zip(seen, expected, strict=True):
        assert parts == pytest.approx(np.array([(0.0, 1.0)] if whole else NOTHING), abs=1e-8)


def free_view(mesh: Mesh, points: Array, eye: Array, parallel: bool, near: float) -> Array:
    """Return whether each of `points` (s, 3) is seen from `eye` (3,), which looks at 0: (s,), by casting rays.

    Each ray is cut with the plane of each polygon, and crossings of the polygon's outline are counted. Nothing is there
    that is not as far as `near` in front of the eye.
    """
    forward = -eye / np.linalg.norm(eye)
    free = np.ones(len(points), np.bool_)
    away = np.broadcast_to(100.0 * forward, points.shape) if parallel else points - eye
    for face, normal in zip(mesh.faces, compute_face_normals(mesh), strict=True):
        corners = mesh.positions[face]
        with np.errstate(divide="ignore", invalid="ignore"):
            back = ((points - corners[0]) @ normal) / (away @ normal)  # from the point to the eye it is 0 to 1
        hit = points - back[:, np.newaxis] * away
        keep = [axis for axis in range(3) if axis != np.argmax(np.abs(normal))]
        flat, outline = hit[:, keep], corners[:, keep]
        crossings = np.zeros(len(points), np.int64)
        for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            across = (a[1] > flat[:, 1]) != (b[1] > flat[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                crossings += across & (flat[:, 0] < a[0] + (flat[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
        in_front = (hit - eye) @ forward > near
        free &= ~((crossings % 2 == 1) & (back > 1e-10) & (back < 1.0) & in_front)
    return free


def assert_as_rays_say(mesh: Mesh, eye: Array, *, orthographic_view: bool, near: float, per_edge: int = 60) -> float:
    """Compare with rays cast at places of every edge but those at the ends of its parts; return what part is seen."""
    camera = Camera.look_at(eye, (0, 0, 0), fov_y=60, near=near, far=100, orthographic=orthographic_view)
    clip_from_model = camera.clip_from_world(1.4)
    edges = mesh.edges
    seen = visible_intervals(mesh, edges, clip_from_model)
    view = clip_to_view(mesh, edges, clip_from_model)
    t = (np.arange(per_edge) + 0.5) / per_edge
    # Halfway in the picture is nearer to the far end in space: 1 / w is what is linear.
    flat = 1.0 / view.clip[..., 3]
    share = t * flat[:, 1:] / ((1.0 - t) * flat[:, :1] + t * flat[:, 1:])
    share = view.between[:, :1] + share * np.diff(view.between, axis=1)
    points = mesh.positions[edges[:, 0], np.newaxis] + share[..., np.newaxis] * np.diff(mesh.positions[edges], axis=1)
    inside = np.isfinite(share).all(axis=1)
    free = free_view(mesh, points[inside].reshape(-1, 3), eye, orthographic_view, near).reshape(-1, per_edge)
    said = np.array([((parts[:, :1] <= t) & (t <= parts[:, 1:])).any(axis=0) for parts in seen])[inside]
    clear = np.array([np.abs(t[:, np.newaxis] - np.append(parts, 2.0)).min(axis=1) > 1e-6 for parts in seen])[inside]
    assert inside.any()
    assert clear.mean() > 0.99
    assert np.array_equal(said[clear], free[clear])
    return float(said.mean())


EYES = {"askew": (4.1, 2.7, 5.3), "below": (-1.3, -4.9, 3.1), "grazing": (6.0, 0.06, 0.11), "close": (1.3, 0.9, 1.2)}
CONCAVE = {
    "L": center(l_prism()),
    "star": star_prism(),
    "boxes": concatenate(*interlocking()),
    "plates": thin_plates(),
    "stairs": center(staircase(), 0.5),
    "torus": samples.torus(13, 8),
    "house in a box": concatenate(samples.house(), box((0.2, -0.4, -2), (0.6, 0.3, 2))),
}


@pytest.mark.slow
@pytest.mark.parametrize("orthographic_view", [False, True])
@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("name", CONCAVE)
def test_rays_agree(name: str, eye: str, orthographic_view: bool) -> None:
    near = 0.4 if eye == "close" else 0.01
    seen = assert_as_rays_say(CONCAVE[name], np.array(EYES[eye]), orthographic_view=orthographic_view, near=near)
    assert 0.0 < seen < 1.0


@given(seed=st.integers(0, 2**32 - 1), orthographic_view=st.booleans())
def test_rays_agree_on_triangles_that_cross_one_another_the_near_plane_and_the_eye(
    seed: int, orthographic_view: bool
) -> None:
    random = np.random.default_rng(seed)
    mesh = Mesh(random.normal(scale=2.0, size=(30, 3)), np.arange(30).reshape(10, 3))
    eye = random.normal(size=3)
    eye *= 2.5 / np.linalg.norm(eye)
    assert_as_rays_say(mesh, eye, orthographic_view=orthographic_view, near=0.3)


@pytest.mark.parametrize("moved", [translate(1e3, -2e3, 5e2), chain(scale(1e-6), translate(1e-4, 0, 2e-4)), scale(1e9)])
def test_neither_size_nor_place_changes_what_is_seen(moved: Array) -> None:
    mesh, clip_from_model = l_prism(), Camera.fit(l_prism()).clip_from_world(1.5)
    there = visible_intervals(mesh.transformed(moved), mesh.edges, clip_from_model @ np.linalg.inv(moved))
    for parts, expected in zip(there, visible_intervals(mesh, mesh.edges, clip_from_model), strict=True):
        assert parts == pytest.approx(expected, abs=1e-6)


def test_a_cap_in_pieces_hides_what_it_hides_whole() -> None:
    whole = star_prism()
    points, k = whole.positions, whole.n_points // 2
    middles = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.6)]
    caps = [(2 * k, (i + 1) % k, i) for i in range(k)] + [(2 * k + 1, i + k, (i + 1) % k + k) for i in range(k)]
    pieces = Mesh(np.concatenate([points, middles]), [*caps, *list(whole.faces)[2:]])
    clip_from_model = Camera.fit(whole, direction=(-0.3, 1.0, -0.2)).clip_from_world(1.0)
    for parts, expected in zip(
        visible_intervals(pieces, whole.edges, clip_from_model),
        visible_intervals(whole, whole.edges, clip_from_model),
        strict=True,
    ):
        assert parts == pytest.approx(expected, abs=1e-8)


def test_what_intervals_leave_free() -> None:
    assert gaps(np.empty((0, 2))).tolist() == [[0.0, 1.0]]
    parts = np.array([(0.5, 0.6), (0.1, 0.2), (0.15, 0.3), (0.3 + MIN_PART / 2, 0.4), (0.52, 0.55)])
    assert gaps(parts).tolist() == [[0.0, 0.1], [0.4, 0.5], [0.6, 1.0]]
    assert gaps(np.array([(0.0, 0.7), (0.2, 1.0)])).tolist() == []
