"""Copies of a mesh as one, against copies that `Mesh.transformed` moves one by one."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import Attributes, Mesh, samples
from gpu_xform.errors import ArgumentError, MeshError
from gpu_xform.formats._concatenate import concatenate
from gpu_xform.geometry.mesh_copies import place_copies
from tests.support.cost import within_cpu_s


def random_matrices(rng: np.random.Generator, n: int) -> Any:
    """Return affine matrices, of which some mirror, one is the identity, one moves alone, and one is singular."""
    matrices = np.tile(np.eye(4), (n, 1, 1))
    matrices[:, :3] += rng.normal(size=(n, 3, 4))
    matrices[0] = np.eye(4)
    matrices[1, :3, :3] = np.eye(3)
    matrices[2, :3, :3] = np.diag([1.0, 0.0, 2.0])
    matrices[3, :3, :3] = np.diag([1.0, 1.0, -1e-200])
    return matrices


def assert_same_columns(columns: Any, expected: Any) -> None:
    assert list(columns) == list(expected)
    for name, column in expected.items():
        assert columns[name].dtype == column.dtype
        exact = column.dtype.kind in "iu"  # rounded: but for a sum just at a half, the same
        np.testing.assert_allclose(columns[name], column, rtol=1e-6, atol=int(exact) or 1e-6)


@given(st.integers(0, 2**32 - 1))
def test_copies_are_those_that_are_moved_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, n_corners = rng.normal(size=(9, 3)), 12
    attributes = Attributes(
        point={
            "normal": rng.normal(size=(9, 3)).astype(np.float32),
            "tangent": rng.normal(size=(9, 4)),
            "color": rng.integers(0, 256, (9, 3), np.uint8),
        },
        corner={"normal": rng.normal(size=(n_corners, 3)), "texcoord": rng.normal(size=(n_corners, 2))},
        face={"normal": rng.integers(-127, 128, (4, 3), np.int8), "material": rng.integers(0, 2, 4, np.int32)},
        labels={"material": ["a", "b"]},
    )
    mesh = Mesh.from_offsets(points, [0, 3, 7, 9, 12], rng.integers(0, 9, n_corners), attributes=attributes)
    for one in (mesh, Mesh(points, [(0, 1, 2), (3, 4, 5)]), Mesh(points)):
        matrices = random_matrices(rng, 12)
        copies, expected = place_copies(one, matrices), concatenate([one.transformed(matrix) for matrix in matrices])
        np.testing.assert_allclose(copies.positions, expected.positions, rtol=1e-14, atol=1e-14)
        assert np.array_equal(copies.offsets, expected.offsets)
        assert np.array_equal(copies.indices, expected.indices)
        for table in ("point", "corner", "face"):
            assert_same_columns(getattr(copies.attributes, table), getattr(expected.attributes, table))
        assert copies.attributes.labels == expected.attributes.labels


def test_attributes_of_copies_that_are_not_turned_are_those_of_the_mesh() -> None:
    normals = np.array([[0.1, 0.2, 0.3], [np.inf, 0.0, 1.0], [-0.0, np.nan, 1e300]])
    mesh = Mesh(np.eye(3), attributes=Attributes(point={"normal": normals}))
    matrices = random_matrices(np.random.default_rng(0), 5)
    moved = place_copies(mesh, matrices).attributes.point["normal"]
    assert moved[:6].tobytes() == np.tile(normals, (2, 1)).tobytes()


def test_one_copy_is_the_mesh_moved_with_its_metadata() -> None:
    cube = samples.cube()
    mesh = cube.with_attributes(cube.attributes, metadata={"gltf": {"extras": 1}})
    assert place_copies(mesh, np.eye(4)[np.newaxis]) is mesh


def test_copies_that_overflow_or_are_not_affine_are_refused() -> None:
    mesh = Mesh([(1e300, 0, 0)])
    with pytest.raises(MeshError, match="finite"):
        place_copies(mesh, np.stack([np.eye(4), np.diag([1e300, 1, 1, 1])]))
    with pytest.raises(ArgumentError, match="matrices"):
        place_copies(mesh, np.stack([np.eye(4), np.ones((4, 4))]))


def test_many_copies_of_a_triangle_take_one_product() -> None:
    normals = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
    mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], attributes={"point": {"normal": normals}})
    matrices = random_matrices(np.random.default_rng(0), 100_000)
    for _ in within_cpu_s(1.5):  # 5 s one by one
        assert place_copies(mesh, matrices).n_faces == 100_000
