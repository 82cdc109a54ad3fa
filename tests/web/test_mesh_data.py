"""What a page is told of a mesh: nothing that it finds out by itself, and all else."""

from typing import Any

import numpy as np
import pytest

from gpu_xform import Layer, Mesh, samples
from gpu_xform.drawing.geometry_source import MeshSource
from gpu_xform.web.arrays import ArrayStore
from gpu_xform.web.mesh_data import GRID_STEPS, describe_mesh
from tests.web.test_arrays import decode

GIVEN = ("triangles", "candidates", "sliver_faces")


def describe(mesh: Mesh) -> tuple[dict[str, Any], list[Any]]:
    store, layer = ArrayStore(), Layer(mesh)
    described = describe_mesh(MeshSource(mesh, "", layer), layer, store)
    return described, decode(store.encode({}))[1]


def test_points_lie_on_a_grid_finer_than_a_millionth_of_the_extent() -> None:
    mesh = samples.house().transformed(np.diag([3.0, 0.5, 2.0, 1.0]))
    described, arrays = describe(mesh)
    grid = arrays[described["positions"]].view(np.int32)
    positions = np.array(described["center"]) + described["half_size"] * described["step"] * grid
    extent = np.ptp(mesh.positions, axis=0).max()
    assert np.abs(positions - mesh.positions).max() <= 0.5 * described["half_size"] / GRID_STEPS * 1.001
    assert np.abs(positions - mesh.positions).max() < 1e-6 * extent


@pytest.mark.parametrize(
    "mesh", [samples.cube(), samples.house(), Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1), (1, 2)])]
)
def test_plain_meshes_say_nothing_of_triangles_and_edges(mesh: Mesh) -> None:
    described, _ = describe(mesh)
    assert not described.keys() & set(GIVEN)


def test_points_that_lie_in_one_place_have_their_edges_told() -> None:
    cube = samples.cube()
    soup = Mesh(cube.positions[cube.indices], np.arange(len(cube.indices)).reshape(-1, 4))
    described, arrays = describe(soup)
    found = arrays[described["candidates"]]
    assert found.shape == (12, 4)
    assert (found[:, 1:3] < 6).all()


def test_concave_faces_have_their_triangles_told() -> None:
    arrow = Mesh([(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0), (-2, -2, 0)], [(1, 2, 3, 4)])
    described, arrays = describe(arrow)
    assert len(arrays[described["triangles"]]) == 2


def test_sharp_edges_are_told_as_bits() -> None:
    described, arrays = describe(samples.cube())
    bits = np.unpackbits(arrays[described["feature"]].astype(np.uint8).ravel(), bitorder="little")
    assert bits[:12].all()
    assert "boundary" not in described
