"""Meshes joined into one, with their attributes."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Mesh
from gpu_xform.errors import MeshWarning
from gpu_xform.formats._concatenate import concatenate, concatenate_placed
from gpu_xform.samples import cube, torus

POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]


def part(**attributes: object) -> Mesh:
    return Mesh(POINTS, [(0, 1, 2)], attributes=attributes)


def test_rows_follow_one_another() -> None:
    meshes = [part(point={"t": np.float32([i, i, i])}, corner={"uv": np.full((3, 2), i)}) for i in range(3)]  # type: ignore[arg-type]
    joined = concatenate(meshes)
    assert joined.attributes.point["t"].tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert joined.attributes.point["t"].dtype == np.float32
    assert joined.attributes.corner["uv"].shape == (9, 2)


def test_what_a_part_lacks_is_filled() -> None:
    full = part(
        point={
            "t": np.ones(3, np.float32),
            "n": np.ones(3, np.int16),
            "color": np.zeros((3, 3), np.uint8),
        },
        face={"material": [0]},
        labels={"material": ["steel"]},
    )
    point = concatenate([part(), full]).attributes.point
    assert np.isnan(point["t"][:3]).all()
    assert point["n"].tolist() == [0, 0, 0, 1, 1, 1]
    assert point["color"].tolist() == [[255, 255, 255]] * 3 + [[0, 0, 0]] * 3
    assert concatenate([part(), full]).attributes.face["material"].tolist() == [-1, 0]


def test_labels_are_numbered_anew() -> None:
    parts = [
        part(face={"material": [i]}, labels={"material": names}, material={name: {"name": name} for name in names})
        for i, names in ((0, ["steel"]), (1, ["paint", "steel"]), (0, ["glass"]), (7, ["wood"]))
    ]
    attributes = concatenate(parts).attributes
    names = attributes.labels["material"]
    numbers = attributes.face["material"].tolist()
    assert [names[number] if number >= 0 else None for number in numbers] == ["steel", "steel", "glass", None]
    assert set(attributes.material) == {"steel", "paint", "glass", "wood"}


def test_files_of_materials_are_all_named_and_clashes_are_told_once(recwarn: pytest.WarningsRecorder) -> None:
    parts = [part(material={"mtllib": names}) for names in (("a.mtl",), ("b.mtl", "a.mtl"))]
    assert concatenate([part(), *parts]).attributes.material == {"mtllib": ("a.mtl", "b.mtl")}
    assert not recwarn.list
    steel = [part(material={"steel": {"Kd": i}, "glass": {"Kd": i}}) for i in range(3)]
    with pytest.warns(MeshWarning, match=r"^several materials each are called 'steel', 'glass', of which") as caught:
        concatenate(steel)
    assert len(caught) == 1


def test_colors_of_two_kinds_become_floats() -> None:
    parts = [
        part(point={"color": np.full((3, 3), 51, np.uint8)}),
        part(point={"color": np.full((3, 4), 0.5, np.float32)}),
    ]
    color = concatenate(parts).attributes.point["color"]
    assert np.allclose(color, [[0.2, 0.2, 0.2, 1]] * 3 + [[0.5] * 4] * 3)


def test_shapes_that_do_not_go_together_are_named() -> None:
    with pytest.warns(MeshWarning, match="t per point differs in shape between the parts of the file"):
        joined = concatenate([part(point={"t": np.ones(3)}), part(point={"t": np.ones((3, 2))})])
    assert not joined.attributes


def test_meshes_where_matrices_put_them_are_each_moved_by_itself() -> None:
    mirror, one = gx.scale(-1, 2, 3) @ gx.translate(1, 2, 3), cube()
    stacks = [[mirror], [mirror], [mirror, np.eye(4), mirror], [np.eye(4), mirror]]
    placed = list(zip((cube(), torus(5, 4), one, torus(5, 4)), map(np.array, stacks), strict=True))
    found = concatenate_placed(placed)
    expected = concatenate([mesh.transformed(matrix) for mesh, matrices in placed for matrix in matrices])
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(found.indices, expected.indices)
    assert np.array_equal(found.offsets, expected.offsets)


def test_copies_of_a_mesh_are_not_moved_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    moved: list[Any] = []
    transformed = Mesh.transformed

    def note(mesh: Mesh, matrix: Any) -> Mesh:
        moved.append(mesh)
        return transformed(mesh, matrix)

    monkeypatch.setattr(Mesh, "transformed", note)
    one, other = cube(), cube()
    stack = np.tile(np.eye(4), (3, 1, 1))
    assert concatenate_placed([(one, stack), (other, stack[:1]), (one, stack[:2])]).n_points == 48
    assert [id(mesh) for mesh in moved] == [id(other)]
