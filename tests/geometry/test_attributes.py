"""Attributes of meshes: what they take, that nobody can write to them, and how they move."""

import copy
import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform import Attributes, Mesh, RaggedArray

MOVED = ("normal", "tangent")
POINTS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)], np.float64)
FACES = [(0, 1, 2, 3), (0, 1, 4), (0, 4)]


def attributed(**changes: Any) -> Mesh:
    """Return a mesh of a quadrilateral, a triangle and a segment with attributes of all kinds."""
    attributes = {
        "point": {
            "normal": np.tile(np.array([0, 0.6, 0.8], np.float32), (5, 1)),
            "intensity": np.arange(5, dtype=np.uint16),
        },
        "corner": {"texcoord": np.arange(18, dtype=np.float32).reshape(9, 2)},
        "face": {"material": np.array([0, 1, -1]), "weights": RaggedArray([1.5, 2.5, 3.5], [0, 1, 1, 3])},
        "labels": {"material": ["steel", "paint"]},
        "material": {"texture": "wood.png", "layers": [{"uv": 0}]},
    }
    return Mesh(POINTS, FACES, attributes=attributes | changes, metadata={"comments": ["made by hand"]})


def test_attributes_keep_their_names_types_and_values() -> None:
    mesh = attributed()
    assert mesh.attributes.point["intensity"].dtype == np.uint16
    assert list(mesh.attributes.point) == ["normal", "intensity"]
    assert mesh.attributes.corner["texcoord"][4].tolist() == [8, 9]
    weights = mesh.attributes.face["weights"]
    assert [row.tolist() for row in weights] == [[1.5], [], [2.5, 3.5]]
    assert weights[-1].tolist() == [2.5, 3.5]
    assert mesh.attributes.labels == {"material": ("steel", "paint")}
    assert mesh.attributes.material["texture"] == "wood.png"
    assert mesh.metadata == {"comments": ("made by hand",)}
    assert not Mesh(POINTS, FACES).attributes


def test_nobody_can_write_to_attributes() -> None:
    intensity = np.arange(5.0)
    read_only = intensity[:]
    read_only.flags.writeable = False
    mesh = attributed(point={"a": intensity, "b": read_only})
    intensity[:] = -1
    for name in "ab":
        assert np.array_equal(mesh.attributes.point[name], np.arange(5.0))
        with pytest.raises(ValueError, match="read-only"):
            mesh.attributes.point[name][0] = 1
    table: Any
    for table in (mesh.attributes.point, mesh.attributes.material, mesh.attributes.material["layers"][0]):
        with pytest.raises(TypeError):
            table["c"] = 1
    with pytest.raises(AttributeError):
        mesh.attributes.point = {}  # type: ignore[misc]


def test_an_array_that_is_closed_to_writing_is_not_copied() -> None:
    mesh = attributed()
    again = Mesh(POINTS, FACES, attributes={"point": mesh.attributes.point})
    assert again.attributes.point["normal"] is mesh.attributes.point["normal"]


def test_what_is_frozen_is_not_frozen_again() -> None:
    given = {"layers": [{"depth": 1}, [], [2, [3]]], "name": "wood"}
    mesh = Mesh(POINTS, FACES, attributes={"material": {"a": given}}, metadata=given)
    assert mesh.metadata == given | {"layers": ({"depth": 1}, (), (2, (3,)))} == mesh.attributes.material["a"]
    assert repr(mesh.metadata) == "{'layers': ({'depth': 1}, (), (2, (3,))), 'name': 'wood'}"
    again = mesh.with_attributes(mesh.attributes, keep=True, metadata={"within": mesh.metadata, **mesh.metadata})
    assert again.metadata["within"] is mesh.metadata
    assert again.metadata["layers"] is mesh.metadata["layers"]
    assert again.attributes.material["a"] is mesh.attributes.material["a"]
    given["layers"][0]["depth"] = 7  # type: ignore[index]
    assert again.metadata["layers"][0]["depth"] == 1


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_copies_and_pickles_have_the_same_attributes(protocol: int) -> None:
    mesh = attributed()
    for twin in (copy.copy(mesh), copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh, protocol))):  # noqa: S301
        assert twin == mesh
        assert twin.metadata == mesh.metadata
        assert not twin.attributes.point["normal"].flags.writeable


def test_attributes_are_replaced_all_or_those_of_a_name() -> None:
    mesh = attributed()
    assert mesh.with_attributes({"point": {"depth": np.arange(5.0)}}).attributes.summarize() == "point: depth"
    kept = mesh.with_attributes({"point": {"intensity": np.arange(5.0)}, "labels": {"layer": ["a"]}}, keep=True)
    assert kept.attributes.point["intensity"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert kept.attributes.labels == {**mesh.attributes.labels, "layer": ("a",)}
    assert kept.attributes.material == mesh.attributes.material
    assert kept.attributes.point["normal"] is mesh.attributes.point["normal"]
    assert kept.attributes.corner.keys() == mesh.attributes.corner.keys()
    assert kept.attributes.face.keys() == mesh.attributes.face.keys()


def test_attributes_count_in_equality_and_metadata_do_not() -> None:
    mesh = attributed()
    assert mesh == mesh.with_attributes(mesh.attributes, metadata={"other": 1})
    changes: dict[str, Any]
    for changes in (
        {"point": {}},
        {"point": {"normal": mesh.attributes.point["normal"], "intensity": np.arange(5)}},  # another type
        {"face": {"material": [0, 1, -1], "weights": RaggedArray([1.5, 2.5, 3.5], [0, 1, 2, 3])}},
        {"labels": {}},
        {"material": {}},
    ):
        assert mesh != attributed(**changes)
    unknown = attributed(point={"depth": [np.nan] * 5})
    assert unknown == attributed(point={"depth": [np.nan] * 5})


def test_repr_names_attributes() -> None:
    mesh = attributed()
    assert (
        repr(mesh)
        == "<Mesh: 5 points, 3 faces; point: normal, intensity; corner: texcoord; face: material, weights; material>"
    )
    assert repr(Mesh(POINTS)) == "<Mesh: 5 points, 0 faces>"
    assert repr(Attributes()) == "<Attributes: none>"
    assert repr(mesh.attributes.face["weights"]) == "<RaggedArray: 3 rows of float64>"


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"point": {"a": [1, 2]}}, "attribute 'a' per point must have 5 rows, got 2"),
        ({"corner": {"a": [1, 2]}}, "attribute 'a' per corner must have 9 rows, got 2"),
        ({"face": {"a": RaggedArray([], [0])}}, "attribute 'a' per face must have 3 rows, got 0"),
        ({"point": {"a": 3}}, "attribute 'a' per point must have one row per point, got one value"),
        ({"point": {"a": [[1], [1, 2]]}}, "attribute 'a' must be a rectangular array, or a RaggedArray: "),
        ({"point": {"a": [None] * 5}}, "attribute 'a' must hold numbers, truth values or texts, got dtype object"),
        ({"point": {3: [1] * 5}}, "the name of an attribute per point must be a text, got 3"),
        ({"points": {}}, "attributes must be among point, corner, face, labels, material, got 'points'"),
        ([1], "attributes must be Attributes or a mapping, got list"),
    ],
)
def test_what_are_no_attributes_is_refused(attributes: Any, message: str) -> None:
    with pytest.raises(gx.MeshError, match=f"^{message}"):
        Mesh(POINTS, FACES, attributes=attributes)


@pytest.mark.parametrize("offsets", [[], [0, 2], [0, 3, 2, 3], [1, 3]])
def test_offsets_of_a_ragged_array_must_fit(offsets: list[int]) -> None:
    with pytest.raises(gx.MeshError, match=r"^offsets must ascend from 0 to 3, the number of values, got"):
        RaggedArray([1, 2, 3], np.array(offsets, int))


def test_normals_stay_perpendicular_and_as_long_as_they_were() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    normals = np.array(ball.vertex_normals, np.float32)
    matrix = gx.chain(gx.scale(3, 1, 0.5), gx.shear(xy=0.4), gx.rotate((1, 2, 3), 0.7), gx.translate(5, 0, 0))
    mesh = Mesh(ball.vertices, ball.faces, attributes={"point": {"normal": normals}})
    moved = mesh.transformed(matrix).attributes.point["normal"]
    expected = gx.transform_normals(normals.astype(np.float64), matrix)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert moved.dtype == np.float32
    assert np.allclose(moved, expected, atol=1e-6)
    double = Mesh(ball.vertices, ball.faces, attributes={"point": {"normal": normals * 2}})
    assert np.allclose(double.transformed(matrix).attributes.point["normal"], expected * 2, atol=1e-6)


def test_normals_survive_tiny_and_singular_matrices() -> None:
    mesh = Mesh(POINTS, attributes={"point": {"normal": np.tile([0.0, 0.6, 0.8], (5, 1))}})
    tiny = mesh.transformed(gx.scale(1e-150)).attributes.point["normal"]
    assert np.allclose(tiny, [0, 0.6, 0.8])
    flat = mesh.transformed(gx.scale(1, 1, 0)).attributes.point["normal"]
    assert np.allclose(flat, [0, 0, 1])
    point = mesh.transformed(gx.scale(0)).attributes.point["normal"]
    assert not np.any(point)
    assert mesh.transformed(gx.identity()) == mesh
    assert np.array_equal(attributed().transformed(gx.scale(-1e-150)).indices, attributed().reversed().indices)


@pytest.mark.parametrize("size", [1.0, 1e30, 1e150, 1e200, 1.7e308, 1e-150, 1e-160, 1e-200, 1e-300, 2.0**-1022])
@pytest.mark.parametrize("exponents", [(0, 0, 0), (-500, 0, 0), (300, -300, 0), (400, 400, -300)])
def test_normals_of_all_lengths_stay_so_under_all_matrices(size: float, exponents: tuple[int, int, int]) -> None:
    """Of those whose squares underflow, zeros were made."""
    rotation, shear = gx.rotate((1, 2, 3), 0.7), gx.shear(xy=0.4)
    normals = size * np.array([[0.6, 0.0, 0.8], [0.0, -0.6, 0.8], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    mesh = Mesh(POINTS, attributes={"point": {"normal": normals}})
    moved = mesh.transformed(rotation @ shear @ gx.scale(*np.ldexp(1.0, exponents))).attributes.point["normal"]
    # Fractions do not underflow: scaling divides by powers of two, and what is left has no extreme numbers.
    linear = np.linalg.inv((rotation @ shear)[:3, :3]).T
    for row, result in zip(normals.tolist(), moved, strict=True):
        scaled = [Fraction(value) / Fraction(2) ** power for value, power in zip(row, exponents, strict=True)]
        largest = max(map(abs, scaled))
        direction = linear @ [float(value / largest) for value in scaled]
        expected = direction / np.linalg.norm(direction)
        assert np.allclose(result / size, expected, rtol=1e-14, atol=1e-15)


def test_normals_of_integers_stay_in_their_range() -> None:
    for dtype in (np.int8, np.uint8, np.int32, np.uint32, np.int64, np.uint64):
        limits = np.iinfo(dtype)
        mesh = Mesh(POINTS, attributes={"point": {name: np.full((5, 3), limits.max, dtype) for name in MOVED}})
        moved = mesh.transformed(gx.rotate((1, -1, 0), 0.9553166)).attributes.point
        for name in MOVED:
            assert moved[name].dtype == dtype
            assert (moved[name][:, 2] >= limits.max - limits.max // 2**50).all()
            assert (np.abs(moved[name][:, :2].astype(float)) <= 1e-7 * limits.max + 1).all()


@pytest.mark.parametrize("size", [1.0, 1e30, 1e150, 1e200, 1.7e308])
def test_normals_that_are_huge_or_not_finite_are_moved_without_a_warning(size: float) -> None:
    matrix = gx.chain(gx.rotate((1, 2, 3), 0.7), gx.scale(3, 1, -0.5))
    normals = np.array([[0.6, 0.0, 0.8], [0.0, -0.6, 0.8], [0.36, 0.48, -0.8], [0.0, 1.0, 0.0], [0.28, 0.96, 0.0]])
    expected = Mesh(POINTS, attributes={"point": {"normal": normals}}).transformed(matrix).attributes.point["normal"]
    given = normals * size
    given[1, 0], given[3, 1] = np.inf, np.nan
    moved = Mesh(POINTS, attributes={"point": {"normal": given, "tangent": given}}).transformed(matrix).attributes
    for rows in (moved.point["normal"], moved.point["tangent"]):
        assert np.array_equal(np.isfinite(rows).any(axis=1), [True, False, True, False, True])
    assert np.allclose(moved.point["normal"][[0, 2, 4]] / size, expected[[0, 2, 4]], rtol=1e-14)
    single = np.full((5, 3), 3e38, np.float32)  # turned, their longest component is beyond float32
    turned = Mesh(POINTS, attributes={"point": {"normal": single}}).transformed(gx.rotate((1, -1, 0), 0.9553166))
    assert np.array_equal(np.isinf(turned.attributes.point["normal"]), np.tile([False, False, True], (5, 1)))


def test_tangents_move_as_vectors_and_mirrors_swap_their_side() -> None:
    tangents = np.tile([1.0, 0.0, 0.0, 1.0], (5, 1))
    mesh = Mesh(POINTS, FACES, attributes={"point": {"tangent": tangents}})
    assert np.array_equal(mesh.transformed(gx.scale(2, 1, 1)).attributes.point["tangent"][0], [2, 0, 0, 1])
    assert np.array_equal(mesh.transformed(gx.scale(-1, 1, 1)).attributes.point["tangent"][0], [-1, 0, 0, -1])
    assert np.array_equal(mesh.transformed(gx.translate(7, 7, 7)).attributes.point["tangent"], tangents)


def test_a_mirrored_face_keeps_its_first_corner_and_its_corners_attributes() -> None:
    mesh = attributed().transformed(gx.reflect((1, 0, 0)))
    assert [face.tolist() for face in mesh.faces] == [[0, 3, 2, 1], [0, 4, 1], [0, 4]]
    texcoord = mesh.attributes.corner["texcoord"]
    assert (texcoord[:, 0] / 2).tolist() == [0, 3, 2, 1, 4, 6, 5, 7, 8]
    assert np.array_equal(mesh.attributes.point["intensity"], np.arange(5))
    assert np.allclose(mesh.attributes.point["normal"], [0, 0.6, 0.8])
    ragged = Mesh(POINTS, [(0, 1, 2)], attributes={"corner": {"r": RaggedArray([1, 2, 3], [0, 1, 1, 3])}})
    assert [row.tolist() for row in ragged.reversed().attributes.corner["r"]] == [[1], [2, 3], []]


@given(st.lists(st.sampled_from([-1.0, 1.0, 2.0, -0.5, 1e-4]), min_size=3, max_size=3), st.floats(-3, 3))
def test_a_solid_keeps_its_positive_volume(factors: list[float], angle: float) -> None:
    matrix = gx.chain(gx.scale(*factors), gx.rotate((1, 2, 3), angle))
    cube = gx.samples.cube()
    moved = cube.transformed(matrix)
    corners = moved.to_trimesh().triangles / np.abs(moved.positions).max()
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    assert volume > 0
    assert moved.transformed(gx.scale(-1)).transformed(gx.scale(-1)) == moved


def test_faces_are_reversed_if_asked_and_only_then() -> None:
    mesh = attributed()
    mirror, turn = gx.scale(1, -1, 1), gx.rotate_z(0.5)
    assert np.array_equal(mesh.transformed(mirror, flip=False).indices, mesh.indices)
    assert np.array_equal(mesh.transformed(mirror, flip=True).indices, mesh.reversed().indices)
    assert np.array_equal(mesh.transformed(turn, flip=True).indices, mesh.reversed().indices)
    assert np.array_equal(mesh.transformed(turn).indices, mesh.indices)
    assert mesh.reversed().reversed() == mesh
    with pytest.raises(gx.ArgumentError, match=r"^flip must be 'auto', True or False, got 'no'$"):
        mesh.transformed(turn, flip="no")  # type: ignore[arg-type]


def test_a_name_that_is_not_there_is_told_with_those_that_are() -> None:
    mesh = Mesh(np.eye(3), attributes={"point": {"temperature": [1, 2, 3], "time": [1, 2, 3]}})
    with pytest.raises(KeyError, match=r"no attribute temperatur per point, .* temperature, time; did you mean temp"):
        mesh.attributes.point["temperatur"]
    with pytest.raises(KeyError, match=r"no attribute area per face, there are: none"):
        mesh.attributes.face["area"]
    assert mesh.attributes.point.get("temp") is None
    assert "temp" not in mesh.attributes.point


def test_a_matrix_that_flattens_by_less_than_any_number_is_no_warning() -> None:
    mesh = gx.samples.cube()
    pointed = gx.Mesh(mesh.positions, mesh.faces, attributes={"point": {"normal": np.tile((0.6, 0.0, 0.8), (8, 1))}})
    matrix = gx.chain(gx.scale(5e-324, 1, 1), gx.rotate_z(90, degrees=True))
    flat = pointed.transformed(matrix)  # slogdet divides by zero for it
    assert np.isfinite(flat.positions).all()
