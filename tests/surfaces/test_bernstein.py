import numpy as np
import pytest

from gpu_xform.surfaces.bernstein import (
    differentiate_bernstein,
    evaluate_bernstein,
    expand_bernstein,
    make_cut,
    make_elevation,
    make_splitting,
)
from tests.support.reference_surfaces import casteljau

DEGREES = [1, 2, 3, 5, 12]


@pytest.mark.parametrize("degree", DEGREES)
def test_the_basis_is_what_de_casteljau_computes(degree: int) -> None:
    t = np.array([0.0, 0.1, 0.5, 0.77, 1.0])
    basis = evaluate_bernstein(degree, t)
    expected = [casteljau(np.eye(degree + 1), x) for x in t]
    np.testing.assert_allclose(basis, expected, rtol=0, atol=4e-16)
    np.testing.assert_allclose(basis.sum(axis=1), 1, rtol=0, atol=1e-15)
    assert basis[0].tolist() == np.eye(degree + 1)[0].tolist()
    assert basis[-1].tolist() == np.eye(degree + 1)[-1].tolist()


@pytest.mark.parametrize("degree", DEGREES)
def test_taylor_coefficients_give_values_and_derivatives(degree: int) -> None:
    t, x = np.array([0.0, 0.3, 1.0]), -0.2
    taylor = expand_bernstein(degree, t)
    np.testing.assert_allclose(taylor[:, 0], evaluate_bernstein(degree, t), rtol=0, atol=1e-15)
    np.testing.assert_allclose(taylor[:, 1], differentiate_bernstein(degree, t), rtol=0, atol=1e-13)
    series = np.einsum("k,mki->mi", x ** np.arange(degree + 1), taylor)
    np.testing.assert_allclose(series, evaluate_bernstein(degree, t + x), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("degree", DEGREES)
def test_pieces_and_curves_of_a_higher_degree_are_the_same_curve(degree: int) -> None:
    points = np.random.default_rng(degree).normal(size=(degree + 1, 3))
    s = np.linspace(0, 1, 7)
    for i, piece in enumerate(make_splitting(degree, 5)):
        expected = evaluate_bernstein(degree, (i + s) / 5) @ points
        np.testing.assert_allclose(evaluate_bernstein(degree, s) @ piece @ points, expected, rtol=0, atol=1e-14)
    raised = make_elevation(degree, degree + 3) @ points
    expected = evaluate_bernstein(degree, s) @ points
    np.testing.assert_allclose(evaluate_bernstein(degree + 3, s) @ raised, expected, rtol=0, atol=1e-14)
    assert make_elevation(degree, degree).tolist() == np.eye(degree + 1).tolist()


@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize(("low", "high"), [(0.0, 0.3), (0.3, 1.0), (0.21, 0.87), (0.4, 0.4001), (0.0, 1.0)])
def test_a_part_of_a_curve_is_that_part(degree: int, low: float, high: float) -> None:
    points = np.random.default_rng(degree).normal(size=(degree + 1, 3))
    cut = make_cut(degree, low, high)
    assert (cut >= 0).all()  # points of a hull, so that rounding stays small
    s = np.linspace(0, 1, 7)
    expected = [casteljau(points, low + (high - low) * x) for x in s]
    np.testing.assert_allclose(evaluate_bernstein(degree, s) @ cut @ points, expected, rtol=0, atol=2e-15)
    if (low, high) == (0.0, 1.0):
        assert cut.tolist() == np.eye(degree + 1).tolist()
