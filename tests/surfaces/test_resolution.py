import numpy as np
import pytest

from gpu_xform.surfaces.bernstein import evaluate_bernstein
from gpu_xform.surfaces.resolution import bound_second_derivatives, choose_steps


def test_the_promise_holds_to_the_last_bit_and_with_no_step_too_many() -> None:
    curve = np.array([[(0, 0, 0), (0.5, 0, 0), (1, 0, 0.3)]])
    largest = float(bound_second_derivatives(curve, 1)[0]) / 8
    for n in range(1, 2000):
        for tolerance in (largest / n**2, np.nextafter(largest / n**2, 0), np.nextafter(largest / n**2, 1)):
            steps = choose_steps(None, float(tolerance), curve)
            assert largest / steps**2 <= tolerance
            assert steps == 1 or largest / (steps - 1) ** 2 > tolerance or steps - n <= 1


@pytest.mark.parametrize("order", [2, 3, 4, 6])
@pytest.mark.parametrize("rational", [False, True])
def test_no_second_derivative_is_above_the_bound(order: int, rational: bool) -> None:
    rng = np.random.default_rng(order)
    points = rng.normal([50, 0, 0], size=(20, order, 3))
    if rational:
        weights = rng.uniform(0.2, 5, (20, order, 1))
        points = np.concatenate([points * weights, weights], axis=2)
    bounds = bound_second_derivatives(points, 1)
    if order == 2 and not rational:
        assert (bounds == 0).all()
        return
    t, h = np.linspace(0.01, 0.99, 99), 1e-3

    def at(s: np.ndarray[tuple[int], np.dtype[np.float64]]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        values = evaluate_bernstein(order - 1, s) @ points
        return values[..., :3] / values[..., 3:] if rational else values

    second = np.linalg.norm(at(t - h) - 2 * at(t) + at(t + h), axis=-1) / h**2
    assert (second.max(axis=1) <= bounds * (1 + 1e-3)).all()
    assert (second.max(axis=1) >= bounds / (2.5 if rational else 3)).mean() > 0.5
