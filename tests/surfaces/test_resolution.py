import numpy as np
import pytest

from gpu_xform._core.types import Float64Array
from gpu_xform.surfaces import resolution
from gpu_xform.surfaces.bernstein import evaluate_bernstein
from gpu_xform.surfaces.resolution import bound_second_derivatives, choose_steps, count_steps


def test_the_promise_holds_to_the_last_bit_and_with_no_step_too_many() -> None:
    curve = np.array([[(0, 0, 0), (0.5, 0, 0), (1, 0, 0.3)]])
    largest = bound_second_derivatives([curve]) / 8
    for n in range(1, 2000):
        for tolerance in (largest / n**2, np.nextafter(largest / n**2, 0), np.nextafter(largest / n**2, 1)):
            steps = choose_steps(None, float(tolerance), [curve])
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
    bounds = np.array([bound_second_derivatives([points[[i]]]) for i in range(len(points))])
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


@pytest.mark.parametrize("shape", [(8, 4), (8, 2, 2), (8, 3, 4)])
def test_the_bound_of_many_is_the_largest_of_all_split_pieces(
    shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The pieces of most are never made: those of curves whose own bound is small."""
    rng = np.random.default_rng(len(shape))
    split: list[int] = []
    whole = resolution._bound_split

    def count(block: Float64Array) -> float:
        split.append(len(block))
        return whole(block)

    n_later = 0
    for _ in range(40):
        weights = rng.uniform(0.2, 5, (*shape, 1))
        points = rng.normal([50, 0, 0], size=(*shape, 3))
        rational = np.concatenate([points * weights, weights], axis=-1)
        bounds = [bound_second_derivatives([rational[[i]]]) for i in range(len(rational))]
        with monkeypatch.context() as patch:
            patch.setattr(resolution, "_bound_split", count)
            patch.setattr(resolution, "_NUMBERS_AT_ONCE", 1)
            assert bound_second_derivatives([rational[:3], rational[3:]]) == max(bounds)
        own = resolution._bound_pieces(np.moveaxis(rational, 0, -1))
        n_later += int(np.argmax(own)) != int(np.argmax(bounds))
    assert n_later > 3  # the curve with the largest bound of its own is often not the one
    assert 40 < sum(split) < 0.7 * 40 * len(rational)
    plain = 2.0**20 * bound_second_derivatives([points])
    assert bound_second_derivatives([rational, 2.0**20 * points]) == max(*bounds, plain)


def test_the_bound_of_too_many_is_larger_but_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    weights = rng.uniform(0.5, 2, (20, 3, 1))
    rational = np.concatenate([rng.normal(size=(20, 3, 3)) * weights, weights], axis=-1)
    near = bound_second_derivatives([rational])
    monkeypatch.setattr(resolution, "_MAX_SPLIT_NUMBERS", 0)
    assert near < bound_second_derivatives([rational]) < 20 * near


def test_a_bound_that_overflows_is_infinite() -> None:
    for points in (
        np.full((1, 3, 3), [[1e308], [-1e308], [1e308]]),
        np.array([[[1e308, 0, 0, 1e-308], [0, 1, 0, 1], [0, 0, 1, 1]]]),
    ):
        assert bound_second_derivatives([points]) == np.inf
        assert count_steps(1.0, [points]) >= 2**53
