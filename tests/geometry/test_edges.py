import math
from collections import defaultdict
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.geometry.edges import compute_face_normals, find_edge_faces, resolve_edges, split_silhouette
from gpu_xform.geometry.mesh import Mesh
from gpu_xform.matrices import chain, rotate, rotate_x, rotate_y, rotate_z, translate
from tests.support.cost import cpu_s, within_cpu_s
from tests.support.meshes import triangles_of

SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def triangulated(mesh: Mesh) -> Mesh:
    return Mesh(mesh.positions, triangles_of(mesh)[0])


def unwelded(mesh: Mesh) -> Mesh:
    """Give every corner a point of its own, as STL does."""
    return Mesh.from_offsets(mesh.positions[mesh.indices], mesh.offsets, np.arange(len(mesh.indices)))


def places(mesh: Mesh, edges: npt.NDArray[np.int64]) -> set[Any]:
    """Return edges as pairs of coordinates."""
    pairs = {frozenset(map(tuple, pair)) for pair in mesh.positions[edges].tolist()}
    assert len(pairs) == len(edges)
    return pairs


def without(mesh: Mesh, *faces: int) -> Mesh:
    return Mesh(mesh.positions, [face for i, face in enumerate(mesh.faces) if i not in faces])


def wedge(degrees: float) -> Mesh:
    """Two triangles that turn by an angle along the edge (0, 1)."""
    a = math.radians(degrees)
    return Mesh([(0, 0, 0), (1, 0, 0), (0, -1, 0), (0, math.cos(a), math.sin(a))], [(1, 0, 2), (0, 1, 3)])


SOLIDS = {
    "cube": samples.cube(),
    "house": samples.house(),
    "snub dodecahedron": samples.snub_dodecahedron(),
    "torus": samples.torus(7, 5),
    "icosphere": samples.icosphere(2),
    "open cube": without(samples.cube(), 0, 3),
    "grid": samples.grid(3),
}
solids = st.sampled_from(sorted(SOLIDS)).map(SOLIDS.__getitem__)


@pytest.mark.parametrize("make", [lambda m: m, triangulated, unwelded, lambda m: unwelded(triangulated(m))])
def test_a_cube_has_twelve_features_below_a_right_angle(make: Any) -> None:
    cube = make(samples.cube())
    for angle in (0.0, 1.0, 30.0, 89.0, 89.999999):
        edges = resolve_edges(cube, "feature", angle)
        assert edges.dtype == np.int64
        assert len(places(cube, edges)) == 12
        lengths = np.linalg.norm(np.diff(cube.positions[edges], axis=1), axis=(1, 2))
        assert (lengths == 2.0).all()
    for angle in (90.0, 91.0, 180.0):
        assert resolve_edges(cube, "feature", angle).shape == (0, 2)
    assert resolve_edges(cube, "boundary").shape == (0, 2)


def test_features_of_the_samples() -> None:
    assert len(resolve_edges(samples.snub_dodecahedron(), "feature", 1)) == 150
    assert len(resolve_edges(samples.snub_dodecahedron(), "feature", 90)) == 0
    assert len(resolve_edges(samples.icosphere(3), "feature")) == 0
    assert len(resolve_edges(samples.icosphere(0), "feature", 41)) == 30  # 180 - 138.19 degrees
    assert len(resolve_edges(samples.icosphere(0), "feature", 42)) == 0
    assert len(resolve_edges(samples.house(), "feature")) == 15
    # The roof turns by the same angle at the ridge as no other edge: 2 atan(0.75).
    ridge = 2.0 * math.degrees(math.atan(0.75))
    below, above = (resolve_edges(samples.house(), "feature", ridge + by) for by in (-1e-9, 1e-9))
    assert len(below) - len(above) == 1


@pytest.mark.parametrize("n", [1, 2, 7])
def test_the_boundary_of_a_grid_is_its_rectangle(n: int) -> None:
    grid = samples.grid(n)
    edges = resolve_edges(grid, "boundary")
    assert len(edges) == 4 * n
    assert (np.abs(grid.positions[edges]).max(axis=2) == 1.0).all()
    assert np.array_equal(resolve_edges(grid, "feature"), edges)
    assert len(places(unwelded(grid), resolve_edges(unwelded(grid), "boundary"))) == 4 * n


@pytest.mark.parametrize("make", [lambda m: m, unwelded])
def test_closed_solids_have_no_boundary_and_a_hole_has_one(make: Any) -> None:
    for mesh in (samples.torus(5, 4), samples.icosphere(2), samples.snub_dodecahedron()):
        assert len(resolve_edges(make(mesh), "boundary")) == 0
        found = find_edge_faces(make(mesh))
        assert (found.n_faces == 2).all()
        assert not found.inconsistent_winding.any()
        assert len(found.edges) == len(mesh.edges)
    sphere = samples.icosphere(3)
    around = np.flatnonzero((np.asarray(sphere.faces) == 20).any(axis=1))
    holed = make(without(sphere, *around))
    assert len(resolve_edges(holed, "feature")) == len(resolve_edges(holed, "boundary")) == len(around)


@given(st.floats(0.001, 179.999), st.booleans(), st.booleans())
def test_the_angle_separates_creases_from_other_edges(degrees: float, turned: bool, apart: bool) -> None:
    mesh = wedge(degrees)
    if turned:
        mesh = Mesh(mesh.positions, [mesh.faces[0], mesh.faces[1][::-1]])
    if apart:
        mesh = unwelded(mesh)
    assert len(resolve_edges(mesh, "boundary")) == 4
    assert len(resolve_edges(mesh, "feature", degrees - 1e-9)) == 5
    assert len(resolve_edges(mesh, "feature", degrees + 1e-9)) == 4


@pytest.mark.parametrize(("degrees", "limit", "shown"), [(1e-7, 9e-8, 5), (1e-7, 1.1e-7, 4), (0, 0, 4), (90, 90, 4)])
def test_small_and_right_angles_are_exact(degrees: float, limit: float, shown: int) -> None:
    assert len(resolve_edges(wedge(degrees), "feature", limit)) == shown


@given(solids, st.tuples(*[st.floats(-3.0, 3.0)] * 6), st.sampled_from([5.0, 25.0, 50.0, 80.0]))
def test_features_move_with_the_mesh(mesh: Mesh, p: tuple[float, ...], angle: float) -> None:
    moved = mesh.transformed(chain(rotate_x(p[0]), rotate_y(p[1]), rotate_z(p[2]), translate(*p[3:])))
    assert np.array_equal(resolve_edges(moved, "feature", angle), resolve_edges(mesh, "feature", angle))
    tiny = mesh.transformed(np.diag([1e-200, 1e-200, 1e-200, 1]))
    assert np.array_equal(resolve_edges(tiny, "feature", angle), resolve_edges(mesh, "feature", angle))


@given(solids, st.randoms(use_true_random=False), st.sampled_from([5.0, 25.0, 50.0, 80.0]), st.booleans())
def test_neither_the_order_of_faces_nor_their_winding_matters(mesh: Mesh, random: Any, angle: float, stl: bool) -> None:
    faces = [face.tolist()[:: random.choice([-1, 1])] for face in mesh.faces]
    random.shuffle(faces)
    mixed = Mesh(mesh.positions, faces)
    if stl:
        mixed = unwelded(mixed)
    assert places(mixed, resolve_edges(mixed, "feature", angle)) == places(mesh, resolve_edges(mesh, "feature", angle))
    assert places(mixed, resolve_edges(mixed, "boundary")) == places(mesh, resolve_edges(mesh, "boundary"))


def described(mesh: Mesh) -> list[Any]:
    """Tell `edge_faces` a second time, slowly: (edge, faces, number of faces, turned, segment) a row."""

    def bordering(sides: list[tuple[int, bool]]) -> list[tuple[int, bool]]:
        return [side for side in sides if [face for face, _ in sides].count(side[0]) == 1]

    sides: dict[tuple[int, int], list[tuple[int, bool]]] = {(a, b): [] for a, b in mesh.edges.tolist()}
    segments = set()
    for i, face in enumerate(mesh.faces):
        corners = face.tolist()
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            edge = (min(a, b), max(a, b))
            if len(face) == 2 and a != b:
                segments.add(edge)
            elif a != b:
                sides[edge].append((i, a < b))
    sides = {edge: bordering(passes) for edge, passes in sides.items()}
    together = defaultdict(list)
    for edge, passes in sides.items():
        if len(passes) == 1:
            a, b = (tuple(mesh.positions[i].tolist()) for i in edge)
            if a == b:
                sides[edge] = []
            else:
                together[min(a, b), max(a, b)].append((edge, passes[0], a < b))
    for same in together.values():
        kept = same[0][0]
        sides[kept] = bordering(sorted((face, forward == upward) for _, (face, forward), upward in same))
        for edge, _, _ in same[1:]:
            del sides[edge]
            if edge in segments:
                segments.add(kept)
    rows = []
    for edge, passes in sides.items():
        faces = [*(face for face, _ in passes[:2]), -1, -1]
        turned = len(passes) > 1 and passes[0][1] == passes[1][1]
        rows.append((edge, faces[:2], len(passes), turned, edge in segments))
    return rows


@given(st.data())
def test_edge_faces_are_what_a_plain_walk_finds(data: st.DataObject) -> None:
    n = data.draw(st.integers(3, 9))
    coordinate = st.sampled_from([-0.0, 0.0, 1.0])
    positions = data.draw(st.lists(st.tuples(coordinate, coordinate, st.just(0.0)), min_size=n, max_size=n))
    faces = data.draw(st.lists(st.lists(st.integers(0, n - 1), min_size=2, max_size=5), max_size=8))
    mesh = Mesh(positions, faces)
    found = find_edge_faces(mesh)
    rows = [
        (tuple(edge), pair, n_faces, turned, segment)
        for edge, pair, n_faces, turned, segment in zip(*(column.tolist() for column in found), strict=True)
    ]
    assert rows == described(mesh)
    assert found.edges.dtype == found.faces.dtype == found.n_faces.dtype == np.int64
    resolve_edges(mesh, "feature")


def test_segments_are_features_and_have_no_faces() -> None:
    mesh = Mesh(samples.cube().positions, [*samples.cube().faces, (7, 0), (0, 1)])
    assert resolve_edges(mesh, "feature", 91).tolist() == [[0, 1], [0, 7]]
    found = find_edge_faces(mesh)
    assert len(found.edges) == 13
    assert found.faces[found.edges.tolist().index([0, 7])].tolist() == [-1, -1]
    assert len(resolve_edges(mesh, "boundary")) == 0


def test_three_faces_at_an_edge_show_it_however_flat() -> None:
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 2, 0)]
    mesh = Mesh(points, [(0, 1, 2), (1, 0, 3), (0, 1, 4)])
    assert [0, 1] in resolve_edges(mesh, "feature", 180).tolist()
    assert [0, 1] not in resolve_edges(mesh, "boundary").tolist()


def test_solids_side_by_side_stay_apart() -> None:
    cube = triangulated(samples.cube())
    both = Mesh(
        np.concatenate([cube.positions, cube.positions + np.array([2.0, 0.0, 0.0])]),
        np.concatenate([np.asarray(cube.faces), np.asarray(cube.faces) + 8]),
    )
    assert len(resolve_edges(both, "feature")) == 24


def test_points_weld_where_they_are_equal_but_for_rounding_and_nowhere_else() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (-0.0, -0.0, 0), (1, 0, 0), (1, -1, 0)], dtype=float)
    faces = [(0, 1, 2), (4, 3, 5)]
    assert len(resolve_edges(Mesh(points, faces), "boundary")) == 4
    points[4, 0] = np.nextafter(1.0, 2.0)
    assert len(resolve_edges(Mesh(points, faces), "boundary")) == 4
    points[4, 0] = 1.0 + 1e-11
    assert len(resolve_edges(Mesh(points, faces), "boundary")) == 6


def test_a_pole_of_needles_shows_no_spokes() -> None:
    """A cap whose quads all end in the pole, in copies of it or in one point: flat, so that only its boundary shows."""
    angles = np.arange(8) * (math.tau / 8)
    boundary = np.stack([np.cos(angles), np.sin(angles), np.zeros(8)], axis=1)
    quads = [(i, i + 8, (i + 1) % 8 + 8, (i + 1) % 8) for i in range(8)]
    copies = Mesh(np.concatenate([np.zeros((8, 3)), boundary]), quads)
    one = Mesh(np.concatenate([np.zeros((1, 3)), boundary]), [(0, i + 1, (i + 1) % 8 + 1, 0) for i in range(8)])
    for mesh in (copies, one, triangulated(copies), triangulated(one), unwelded(triangulated(copies))):
        assert len(places(mesh, resolve_edges(mesh, "feature"))) == 8
        assert len(resolve_edges(mesh, "boundary")) == 8


def test_a_crease_is_found_across_a_face_without_area() -> None:
    outline = [(0, 0), (1, 0), (1, 0), (1, 1), (0, 1)]  # one corner twice
    points = [(x, y, z) for z in (0, 1) for x, y in outline]
    sides = [(i, (i + 1) % 5, (i + 1) % 5 + 5, i + 5) for i in range(5)]
    prism = Mesh(points, [(4, 3, 2, 1, 0), (5, 6, 7, 8, 9), *sides])
    wound_anyhow = Mesh(points, [face[::-1] if i % 2 else face for i, face in enumerate(prism.faces)])
    for mesh in (prism, triangulated(prism), wound_anyhow):
        assert len(places(mesh, resolve_edges(mesh, "feature"))) == 12
    turned = rotate((1, 2, 3), 0.7)  # where points in line are so but for rounding
    split = Mesh([(0, 0, 0), (3, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 3), (2, 1, 3), (0, 1, 2), (1, 0, 4)])
    for mesh in (split, split.transformed(turned), split.transformed(turned @ rotate((3, 1, 2), 0.4))):
        assert resolve_edges(mesh, "feature").tolist() == [[0, 2], [0, 3], [0, 4], [1, 2], [1, 3], [1, 4]]


def test_the_bridge_to_a_hole_is_neither_feature_nor_boundary() -> None:
    outer, hole = np.array(SQUARE) * 4.0, np.array(SQUARE)[::-1] + np.array([1.0, 1.0, 0.0])
    mesh = Mesh(np.concatenate([outer, hole]), [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)])
    assert len(resolve_edges(mesh, "boundary")) == len(resolve_edges(mesh, "feature", 0)) == 8
    assert [0, 4] not in resolve_edges(mesh, "boundary").tolist()
    assert [0, 4] in find_edge_faces(mesh).edges.tolist()


def test_normals_are_newells_of_length_one() -> None:
    mesh = Mesh(
        [*SQUARE, (0, 0, 1), (2, 0, 0)], [(0, 1, 2, 3), (3, 2, 1, 0), (0, 4, 1), (0, 1), (0, 1, 5), (0, 0, 0, 0)]
    )
    expected = [[0, 0, 1], [0, 0, -1], [0, 1, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    assert compute_face_normals(mesh).tolist() == expected
    solid = samples.snub_dodecahedron()
    normals = compute_face_normals(solid)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, rel=1e-15)
    for face, normal in zip(solid.faces, normals, strict=True):
        corners = solid.positions[face]
        assert corners @ normal == pytest.approx(float(corners.mean(axis=0) @ normal), rel=1e-14)
        assert corners[0] @ normal > 0.0
    assert compute_face_normals(Mesh([])).shape == (0, 3)


@pytest.mark.parametrize("mesh", [Mesh([]), Mesh(SQUARE), Mesh(SQUARE, [(0, 0)]), Mesh(SQUARE, [(1, 1, 1)])])
def test_meshes_without_edges_have_none_to_draw(mesh: Mesh) -> None:
    for name in ("all", "feature", "boundary"):
        assert resolve_edges(mesh, name).shape == (0, 2)
    assert [len(column) for column in find_edge_faces(mesh)] == [0] * 5


def test_names_stand_for_their_edges() -> None:
    mesh = without(triangulated(samples.cube()), 0)
    assert np.array_equal(resolve_edges(mesh, "all"), mesh.edges)
    assert len(resolve_edges(mesh, "boundary")) == len(resolve_edges(mesh, "feature", 91.0)) == 3
    assert len(resolve_edges(mesh, "feature", 10.0)) == len(resolve_edges(mesh, "feature")) == 13


@pytest.mark.parametrize("edges", [[(5, 2), (0, 1), (0, 1)], np.array([[5, 2], [0, 1], [0, 1]], np.uint8)])
def test_an_array_alone_keeps_its_rows(edges: Any) -> None:
    found = resolve_edges(samples.cube(), edges)
    assert found.tolist() == [[5, 2], [0, 1], [0, 1]]
    assert found.dtype == np.int64


def test_sets_combine_to_each_edge_once_in_order() -> None:
    mesh = without(triangulated(samples.cube()), 0)
    extra = np.array([(7, 0), (1, 0), (0, 1)])
    found = resolve_edges(mesh, ["boundary", extra, "feature", [(6, 1)]])
    expected = {*map(tuple, resolve_edges(mesh, "feature").tolist()), (0, 7), (0, 1), (1, 6)}
    assert list(map(tuple, found.tolist())) == sorted(expected)
    assert found.dtype == np.int64
    assert np.array_equal(resolve_edges(mesh, {"all", "feature"}), mesh.edges)
    assert resolve_edges(mesh, (extra, extra[1:])).tolist() == [[0, 1], [0, 7]]
    nothings: list[Any] = [[], (), np.empty((0, 2), np.int64)]
    for nothing in nothings:
        assert resolve_edges(mesh, nothing).shape == (0, 2)


def test_the_silhouette_is_taken_out_for_each_view_to_find() -> None:
    assert split_silhouette("silhouette") == (None, True)
    assert split_silhouette("feature") == ("feature", False)
    assert split_silhouette(["silhouette", "boundary"]) == ("boundary", True)
    assert split_silhouette(iter(["feature", "silhouette", "boundary"])) == (["feature", "boundary"], True)
    assert split_silhouette("feature, silhouette,boundary") == (["feature", "boundary"], True)
    pairs = np.array([(0, 1), (2, 1)])
    rest, found = split_silhouette([pairs, "silhouette"])
    assert rest is pairs
    assert found
    assert split_silhouette([[0, 1], [1, 2]]) == ([[0, 1], [1, 2]], False)


@pytest.mark.parametrize(
    ("edges", "error", "message"),
    [
        (
            "outline",
            ArgumentError,
            r"^edges must be 'all', 'feature', 'boundary', 'silhouette', 'inter.* or an array of shape \(m, 2\), got",
        ),
        (["all", "Feature"], ArgumentError, "got 'Feature'"),
        ([(0, 1), (2, 8)], ArgumentError, r"^edges names point 8 in row 1, outside 0..7 \(8 points\)"),
        (["all", [(0, -1)]], ArgumentError, "edges names point -1 in row 0"),
        (np.array([[0, 2**64 - 1]], np.uint64), ArgumentError, "edges names point 18446744073709551615"),
        ([(0, 1.0)], ArgumentTypeError, "^edges must hold integers, got dtype float64"),
        ([(True, False)], ArgumentTypeError, "edges must hold integers, got dtype bool"),
        (["all", (0, "b")], ArgumentTypeError, "edges must hold integers, got dtype <U"),
        ([0, 1], ArgumentError, r"edges must have shape \(m, 2\), got \(2,\)"),
        ([(0, 1, 2)], ArgumentError, r"edges must have shape \(m, 2\), got \(1, 3\)"),
        ([(0, 1), (2,)], ArgumentError, r"edges must have shape \(m, 2\): "),
        (np.array(3), ArgumentError, r"edges must have shape \(m, 2\), got \(\)"),
        (None, ArgumentTypeError, "edges must be a name, an array, or several of these, got NoneType"),
        (3, ArgumentTypeError, "got int"),
    ],
)
def test_what_is_no_set_of_edges_is_refused(edges: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        resolve_edges(samples.cube(), edges)


@pytest.mark.parametrize("angle", [-1.0, 180.1, math.nan, math.inf])
def test_angles_outside_0_to_180_degrees_are_refused(angle: float) -> None:
    for name in ("all", "feature"):
        with pytest.raises(ArgumentError, match=r"^feature_angle must be"):
            resolve_edges(samples.cube(), name, angle)


@pytest.mark.slow
def test_many_triangles_cost_a_few_sorts() -> None:
    keys = np.random.default_rng(0).integers(0, 2**63, 1_000_000, dtype=np.uint64)
    one_sort = cpu_s(lambda: np.argsort(keys, kind="stable"))
    mesh = triangulated(samples.grid(350))
    assert mesh.n_faces == 245_000
    for _ in within_cpu_s(10 * one_sort + 0.5):
        assert len(resolve_edges(mesh, "feature")) == 4 * 350


def sphere_with_a_seam(n: int, offset: float = 0.0) -> Mesh:
    """Return a sphere of n x n quads whose first and last meridian differ by rounding, as sin(2 pi) is not 0."""
    longitude, latitude = np.meshgrid(np.linspace(0, 2 * np.pi, n + 1), np.linspace(0.3, 2.8, n + 1), indexing="ij")
    x, y, z = np.sin(latitude) * np.cos(longitude), np.sin(latitude) * np.sin(longitude), np.cos(latitude)
    index = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3) + offset, quads)


@pytest.mark.parametrize("offset", [0.0, 1e3, -4e6])
def test_seams_that_differ_by_rounding_are_joined(offset: float) -> None:
    n = 24
    mesh = sphere_with_a_seam(n, offset)
    seam = np.abs(mesh.positions[: n + 1] - mesh.positions[-n - 1 :]).max()
    assert seam > 0.0 or offset
    assert len(resolve_edges(mesh, "boundary")) == 2 * n  # the two rims, and no meridian
    assert len(resolve_edges(mesh, "feature")) == 2 * n


def test_seams_that_stand_open_stay_open() -> None:
    n = 24
    mesh = sphere_with_a_seam(n)
    positions = mesh.positions.copy()
    positions[-n - 1 :, 1] += 1e-9
    assert len(resolve_edges(Mesh(positions, mesh.faces), "boundary")) == 4 * n


def test_features_are_the_edges_of_brep_faces_whatever_their_angle() -> None:
    """A flat square of two triangles of two faces, and a fold within one face."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 3), (2, 1, 3)]
    faces = [(0, 1, 2), (0, 2, 3), (1, 4, 2), (4, 5, 2)]
    flat = Mesh(points, faces, attributes={"face": {"brep_face": [0, 1, 0, 0]}})
    edges = {tuple(edge) for edge in resolve_edges(flat, "feature").tolist()}
    assert (0, 2) in edges
    assert (1, 2) not in edges
    assert (2, 4) not in edges
    # A face of none is judged by the angle.
    mixed = Mesh(points, faces, attributes={"face": {"brep_face": [-1, 1, 0, 0]}})
    edges = {tuple(edge) for edge in resolve_edges(mixed, "feature").tolist()}
    assert (1, 2) in edges
    assert (0, 2) not in edges
    texts = Mesh(points, faces, attributes={"face": {"brep_face": ["a", "b", "c", "d"]}})
    assert (1, 2) in {tuple(edge) for edge in resolve_edges(texts, "feature").tolist()}
