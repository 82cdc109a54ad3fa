"""Single lines against the exact area of a capsule over each pixel."""

import numpy as np
import pytest

from gpu_xform import Camera, Mesh, render_array
from tests.support.reference_coverage import capsule_areas
from tests.support.types import Array

CELL = 48
CELLS_A_SIDE = 7


def lines(line_width: float) -> tuple[Array, Array]:
    """Return the ends of lines in a cell (k, 2): all slopes, and almost upright ones, and lengths from a point on."""
    random = np.random.default_rng(int(line_width * 10))
    k = CELLS_A_SIDE**2
    angles = np.concatenate([np.arange(16) * np.pi / 8, random.uniform(0, 2 * np.pi, k - 24)])
    almost_upright = random.integers(0, 4, 8) * np.pi / 2 + random.uniform(-0.02, 0.02, 8)
    angles = np.concatenate([angles, almost_upright])
    lengths = np.where(random.random(k) < 0.4, random.uniform(0.0, 3.0, k), random.uniform(3.0, 30.0, k))
    lengths[0] = 0.0
    centers = random.uniform(22.0, 26.0, (k, 2))
    halves = 0.5 * lengths[:, np.newaxis] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return centers - halves, centers + halves


def draw(a: Array, b: Array, line_width: float) -> Array:
    """Draw each line in a cell of its own; return the cells' alpha (k, CELL, CELL) from 0 to 1."""
    side = CELLS_A_SIDE * CELL
    corners = CELL * np.array([(i % CELLS_A_SIDE, i // CELLS_A_SIDE) for i in range(len(a))])
    points = np.zeros((2 * len(a), 3))
    points[0::2, :2], points[1::2, :2] = a + corners, b + corners
    points[:, 1] = side - points[:, 1]
    picture = render_array(
        Mesh(points, np.arange(len(points)).reshape(-1, 2)),
        camera=Camera.window((0, side), (0, side)),
        size=(side, side),
        line_width=line_width,
        background=None,
    )
    cells = picture[..., 3].reshape(CELLS_A_SIDE, CELL, CELLS_A_SIDE, CELL).swapaxes(1, 2)
    return cells.reshape(-1, CELL, CELL) / 255.0


@pytest.mark.parametrize("line_width", [0.5, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0])
def test_every_pixel_is_lit_by_how_much_of_it_the_line_covers(line_width: float) -> None:
    starts, ends = lines(line_width)
    pixel_y, pixel_x = np.mgrid[:CELL, :CELL] + 0.5
    errors_beside, errors_at_ends = [], []
    for a, b, got in zip(starts, ends, draw(starts, ends, line_width), strict=True):
        exact = capsule_areas(a, b, line_width, (CELL, CELL))
        error = np.abs(got - exact)
        length = float(np.hypot(*(b - a)))
        tangent = (b - a) / length if length > 0.0 else np.array([1.0, 0.0])
        station = (pixel_x - a[0]) * tangent[0] + (pixel_y - a[1]) * tangent[1]
        reach = 0.5 * np.abs(tangent).sum()
        beside = (station >= reach) & (station <= length - reach)
        touched = (exact > 0.0) | (got > 0.0)
        errors_beside.append(error[touched & beside])
        errors_at_ends.append(error[touched & ~beside])
    for errors in (np.concatenate(errors_beside), np.concatenate(errors_at_ends)):
        assert len(errors) > 100
        assert errors.mean() <= 2 / 255
        assert errors.max() <= 16 / 255
    assert np.concatenate(errors_beside).max() <= 5 / 255


@pytest.mark.parametrize("line_width", [0.05, 0.3, 1.0, 2.5, 6.0])
@pytest.mark.parametrize("angle", np.arange(8) * 0.4)
def test_the_coverage_of_a_line_is_its_area(line_width: float, angle: float) -> None:
    half = 20.0 * np.array([np.cos(angle), np.sin(angle)])
    middle = np.array([24.3, 23.6])
    coverage = draw((middle - half)[np.newaxis], (middle + half)[np.newaxis], line_width)[0].sum()
    area = 40.0 * line_width + np.pi / 4 * line_width**2
    assert abs(coverage - area) <= 0.02 * area + 0.2  # the second term: eight bits a pixel


def test_a_line_without_length_is_a_round_point() -> None:
    center = np.array([20.2, 27.7])
    point = draw(center[np.newaxis], center[np.newaxis], 10.0)[0]
    assert abs(point.sum() - np.pi * 25) < 0.5
    assert np.abs(point - capsule_areas(center, center, 10.0, (CELL, CELL))).max() <= 16 / 255


def test_a_line_looks_the_same_from_both_ends() -> None:
    starts, ends = lines(1.5)
    assert np.abs(draw(starts, ends, 1.5) - draw(ends, starts, 1.5)).max() <= 2 / 255
