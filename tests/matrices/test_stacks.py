"""Stacks of matrices: arrays of angles and vectors give (..., 4, 4), each of which is what one alone gives."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gpu_xform import errors, planar
from gpu_xform.matrices import (
    chain,
    decompose,
    homogeneous,
    inverse,
    look_at,
    perspective_from_eye,
    reflect,
    rotate,
    rotate_x,
    rotate_y,
    rotate_z,
    scale,
    shear,
    translate,
)
from tests.support.types import Array

ANGLES = np.array([[0.0, 0.3, -2.5], [90.0, -270.0, 1e6]])
MAKERS: list[Callable[[Any], Array]] = [
    rotate_x,
    rotate_y,
    rotate_z,
    lambda a: rotate_z(a, degrees=True),
    lambda a: rotate((1, -2, 3), a, point=(4, 5, 6)),
    lambda a: rotate((1, -2, 3), a, point=(4, 5, 6), degrees=True),
    lambda a: scale(a),
    lambda a: scale(1.0, a, 3.0),
    lambda a: translate(1.0, 2.0, a),
    lambda a: shear(xy=a, zx=0.5),
    lambda a: planar.rotate(a, point=(1, 2)),
    lambda a: planar.translate(a, 1),
    lambda a: planar.scale(a),
    lambda a: planar.shear(yx=a),
]


@pytest.mark.parametrize("make", MAKERS)
def test_a_stack_is_what_its_numbers_give_alone(make: Callable[[Any], Array]) -> None:
    stack = make(ANGLES)
    alone = np.array([[make(float(angle)) for angle in row] for row in ANGLES])
    assert stack.shape == alone.shape
    assert stack.flags.c_contiguous
    assert np.abs(stack - alone).max() <= 4e-16 * np.abs(alone).max()
    assert make(ANGLES[:0]).shape == (0, *alone.shape[1:])
    assert make(np.array(2)).shape == alone.shape[2:]


def test_quarter_turns_are_exact_in_degrees() -> None:
    stack = rotate_y(np.arange(-1080, 1081, 90), degrees=True)
    assert np.array_equal(stack, np.rint(stack))
    assert np.array_equal(stack[1::4], np.tile(rotate_y(90, degrees=True), (6, 1, 1)))


def test_rotations_are_those_of_scipy() -> None:
    angles = np.linspace(-7, 7, 100)
    for axis, make in zip("xyz", (rotate_x, rotate_y, rotate_z), strict=True):
        expected = Rotation.from_euler(axis, angles[:, None]).as_matrix()
        assert np.abs(make(angles)[:, :3, :3] - expected).max() < 1e-15
        assert np.array_equal(homogeneous(expected)[:, :3, :3], expected)
        assert np.array_equal(homogeneous(Rotation.from_euler(axis, angles[:, None]))[:, :3, :3], expected)


def make_stack(shape: tuple[int, ...], seed: int = 0) -> Array:
    rng = np.random.default_rng(seed)
    stack = rng.normal(size=(*shape, 4, 4))
    stack[..., 3, :] = 0, 0, 0, 1
    return stack


def test_a_chain_broadcasts() -> None:
    a, b, c = make_stack((3, 1), 1), make_stack((2,), 2), rotate_z(0.3)
    product = chain(a, b, c)
    assert product.shape == (3, 2, 4, 4)
    for i in range(3):
        for j in range(2):
            assert np.abs(product[i, j] - chain(a[i, 0], b[j], c)).max() < 1e-13
    with pytest.raises(errors.ArgumentError, match=r"matrices\[1\] must broadcast with a stack \(3,\), got \(2,\)"):
        chain(make_stack((3,)), make_stack((2,)))


@given(seed=st.integers(0, 999), shape=st.sampled_from([(1,), (5,), (2, 3)]), share=st.sampled_from([0.0, 0.5, 1.0]))
def test_inverses_of_a_stack_are_those_of_its_matrices(seed: int, shape: tuple[int, ...], share: float) -> None:
    stack = make_stack(shape, seed)
    is_projective = np.random.default_rng(seed).uniform(size=shape) < share
    stack[is_projective, 3] = 0.1, 0.2, -0.3, 1.5
    inverted = inverse(stack)
    for place in np.ndindex(shape):
        alone = inverse(stack[place])
        assert np.abs(inverted[place] - alone).max() <= 1e-11 * np.abs(alone).max() * np.linalg.cond(stack[place])
        if not is_projective[place]:
            assert inverted[place][3].tolist() == [0, 0, 0, 1]


def test_the_singular_one_is_named() -> None:
    stack = make_stack((2, 3))
    stack[1, 2] = perspective_from_eye(5.0)
    with pytest.raises(errors.SingularMatrixError, match=r"got a singular one in matrix \(1, 2\): balanced"):
        inverse(stack)
    with pytest.raises(errors.SingularMatrixError, match=r"got a singular one in matrix 1: balanced"):
        decompose(np.stack([np.eye(4), scale(1, 0, 1)]))
    with pytest.raises(errors.ArgumentError, match=r"m must be affine.*got \(0, 0, -0.2, 1\) in matrix 2"):
        decompose(stack[1])


@pytest.mark.parametrize("shape", [(0,), (7,), (2, 3)])
def test_the_parts_of_a_stack_are_those_of_its_matrices(shape: tuple[int, ...]) -> None:
    stack = make_stack(shape, 4)
    if stack.size:
        stack[(0,) * len(shape)] = reflect((1, 2, 3))
    parts = decompose(stack)
    assert [part.shape for part in parts] == [(*shape, 3), (*shape, 3, 3), (*shape, 3), (*shape, 3)]
    for place in np.ndindex(shape):
        for part, alone in zip(parts, decompose(stack[place]), strict=True):
            assert np.abs(part[place] - alone).max() < 1e-12
    assert np.abs(parts.as_matrix() - stack).max(initial=0.0) < 1e-12


def test_cameras_look_from_each_eye_at_each_target() -> None:
    rng = np.random.default_rng(2)
    eyes, target, ups = rng.normal(size=(4, 1, 3)), (0.1, 0.2, 0.3), rng.normal(size=(5, 3))
    views = look_at(eyes, target, ups)
    assert views.shape == (4, 5, 4, 4)
    for i in range(4):
        for j in range(5):
            assert np.abs(views[i, j] - look_at(eyes[i, 0], target, ups[j])).max() < 1e-14
    with pytest.raises(errors.ArgumentError, match=r"eye and target must differ.*in matrix 1$"):
        look_at([(1, 2, 3), (0, 0, 0)], (0, 0, 0))
    with pytest.raises(errors.ArgumentError, match=r"up must not be parallel to .* in matrix 1$"):
        look_at((0, 0, 5), (0, 0, 0), [(0, 1, 0), (0, 0, 2)])
    with pytest.raises(errors.ArgumentError, match="eye and target and up must broadcast"):
        look_at(eyes[:, 0], np.zeros((3, 3)))
