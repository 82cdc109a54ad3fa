"""Curves and surfaces in OBJ files."""

import io
import math
import re
import sys
import tracemalloc
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.formats import obj_free_forms
from gpu_xform.surfaces.bernstein import evaluate_bernstein
from gpu_xform.surfaces.newell_teapot import make_teapot_patches
from tests.support.cost import within_cpu_s

TEAPOT = make_teapot_patches(bottom=True, fit_lid=False)


def load(text: str, tolerance: float | None = None) -> gx.Mesh:
    return gx.load_mesh(io.BytesIO(text.encode()), file_type="obj", tolerance=tolerance)


def write_patches(form: str) -> str:
    """Return the teapot as text: its points each once, and its patches, u fastest."""
    points, numbers = np.unique(TEAPOT.reshape(-1, 3), axis=0, return_inverse=True)
    lines = ["v {} {} {}".format(*point) for point in points.tolist()]
    for patch in numbers.reshape(32, 4, 4) + 1:
        names = " ".join(map(str, patch.T.reshape(-1).tolist()))
        if form == "bzp":
            lines.append(f"bzp {names}")
        else:
            knots = "0 1" if "bezier" in form else "0 0 0 0 1 1 1 1"
            lines += [f"cstype {form}", "deg 3 3", f"surf 0 1 0 1 {names}", f"parm u {knots}", f"parm v {knots}", "end"]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("form", ["bzp", "bezier", "bspline", "rat bezier"])
@pytest.mark.parametrize("tolerance", [0.1, 0.01])
def test_the_teapot_is_read(form: str, tolerance: float) -> None:
    mesh = load(write_patches(form), tolerance)
    expected = gx.bezier(TEAPOT, tolerance=tolerance)
    if form != "rat bezier":  # of rational patches the bound is another
        assert (mesh.n_points, mesh.n_faces) == (expected.n_points, expected.n_faces)
        np.testing.assert_allclose(mesh.positions[mesh.indices], expected.positions[expected.indices], atol=1e-14)
        normals = expected.attributes.corner["normal"]
        np.testing.assert_allclose(mesh.attributes.corner["normal"], normals, rtol=0, atol=1e-12)
    else:
        assert mesh.n_faces >= expected.n_faces


def test_both_readers_agree_and_the_default_tolerance_is_a_thousandth() -> None:
    text = write_patches("bzp")
    broken = re.sub(r"(bzp(?: \d+){8}) ", r"\1 \\\n", text)
    assert load(text, 0.05) == load(broken, 0.05)
    points = np.unique(TEAPOT.reshape(-1, 3), axis=0)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert load(text) == load(text, float(diagonal) / 1000)


ARC = f"""v 1 0 0 1
v 1 1 0 {math.sqrt(0.5)!r}
v 0 1 0 1
v 5 5 5
cstype rat bezier
deg 2
"""


def test_a_rational_curve_is_an_arc() -> None:
    mesh = load(ARC + "curv 0 1 1 2 -2\nparm u 0 1\nend\np 4\n", 1e-3)
    segments = mesh.positions[mesh.indices.reshape(-1, 2)]
    np.testing.assert_allclose(np.linalg.norm(segments, axis=-1), 1, rtol=0, atol=1e-15)
    assert segments[0, 0].tolist() == [1, 0, 0]
    assert segments[-1, 1].tolist() == [0, 1, 0]
    middles = np.linalg.norm(segments.mean(axis=1), axis=-1)
    assert 1e-4 < 1 - middles.min() < 1e-3
    assert mesh.positions[3].tolist() == [5, 5, 5]  # points that `p` draws keep their numbers


def test_control_points_are_no_points_of_the_mesh_unless_a_face_names_them() -> None:
    mesh = load(ARC.replace("v 5 5 5", "v 0 0 1 1") + "curv 0 1 1 2 3\nparm u 0 1\nend\nl 2 4\n", 1e-2)
    assert [1, 1, 0] in mesh.positions.tolist()
    lone = load(ARC + "curv 0 1 1 2 3\nparm u 0 1\nend\n", 1e-2)
    assert lone.positions.tolist()[0] == [5, 5, 5]  # of no form
    assert [1, 1, 0] not in lone.positions.tolist()


def test_a_part_of_a_curve_is_cut_out() -> None:
    points = np.random.default_rng(2).normal(size=(7, 3))
    vertices = "".join("v {!r} {!r} {!r}\n".format(*point) for point in points.tolist())
    text = f"{vertices}cstype bezier\ndeg 3\ncurv 0.5 5 1 2 3 4 5 6 7\nparm u 0 2 6\nend\n"
    mesh = load(text, 1e-3)
    ends = [
        (evaluate_bernstein(3, np.array([0.25])) @ points[:4])[0],
        (evaluate_bernstein(3, np.array([0.75])) @ points[3:])[0],
    ]
    np.testing.assert_allclose(mesh.positions[mesh.indices[[0, -1]]], ends, rtol=0, atol=1e-14)
    assert mesh.n_faces % 2 == 0
    assert points[3].tolist() in mesh.positions.tolist()


@pytest.mark.parametrize(("kind", "knots"), [("bezier", "0 1 2 3"), ("bspline", "-1 0 1 2 3 4")])
def test_a_part_that_begins_and_ends_between_pieces_has_no_piece_of_no_length(kind: str, knots: str) -> None:
    points = "".join(f"v {x} {x * x % 5} 0\n" for x in range(4))
    text = f"{points}cstype {kind}\ndeg 1\ncurv 1 2 1 2 3 4\nparm u {knots}\nend\n"
    mesh = load(text, 0.1)
    assert mesh.positions.tolist() == [[1, 1, 0], [2, 4, 0]]
    assert mesh.indices.tolist() == [0, 1]


def test_surfaces_stand_where_the_file_has_them_and_keep_materials_and_normals() -> None:
    text = """v 0 0 0
v 2 0 0
v 0 2 1
v 2 2 0
vn 0 0 1
vt 0 0
usemtl wood
f 1/1/1 2/1/1 3/1/1
usemtl stone
cstype bezier
deg 1 1
surf 0 1 0 1 1 2 3 4
parm u 0 1
parm v 0 1
end
usemtl wood
f 2 4 3
g last
curv 0 1 1 2
cstype bezier
deg 1
curv 0 1 1 4
parm u 0 1
end
f 1 2 4
"""
    with pytest.warns(gx.MeshWarning, match="not shown: 1 curv; line 19: curv needs parm u"):
        mesh = load(text, 0.5)
    assert np.diff(mesh.offsets).tolist() == [3, 4, 3, 2, 3]
    labels = mesh.attributes.labels
    names = [labels["material"][i] for i in mesh.attributes.face["material"]]
    assert names == ["wood", "stone", "wood", "wood", "wood"]
    assert [i >= 0 for i in mesh.attributes.face["group"]] == [False, False, False, True, True]
    quad = mesh.indices[mesh.offsets[1] : mesh.offsets[2]]
    assert mesh.positions[quad].tolist() == [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 1]]
    normals = mesh.attributes.corner["normal"]
    assert normals[:3].tolist() == [[0, 0, 1]] * 3
    np.testing.assert_allclose(normals[3], np.array([0, -0.5, 1]) / math.sqrt(1.25), rtol=0, atol=1e-15)
    assert np.isnan(normals[7:]).all()
    assert np.isnan(mesh.attributes.corner["texcoord"][3:]).all()


def test_surfaces_of_several_degrees_are_welded() -> None:
    grid = [(x, y, x * y + x * x) for y in (0.0, 1.0) for x in (0.0, 1.0, 2.0)]
    vertices = "".join("v {} {} {}\n".format(*point) for point in [*grid, (0, -1, 0), (2, -1, 4)])
    text = f"""{vertices}cstype bezier
deg 2 1
surf 0 1 0 1 1 2 3 4 5 6
parm u 0 1
parm v 0 1
end
deg 1 1
surf 0 1 0 1 7 8 1 3
parm u 0 1
parm v 0 1
end
"""
    mesh = load(text, 0.05)
    n = round(math.sqrt(mesh.n_faces / 2))
    assert mesh.n_faces == 2 * n * n
    assert mesh.n_points == 2 * (n + 1) ** 2 - 2  # corners alone: one border is bent, the other is not


def test_forms_of_all_kinds_stay_in_the_order_of_the_file() -> None:
    """They are made polygons of kind by kind, and degree by degree; materials hold for what stands behind them."""
    surface = "deg {0} 1\nsurf 0 1 0 1 {1}\nparm u 0 1\nparm v 0 1\nend\n"
    curve = "deg 1\ncurv 0 1 1 2\nparm u 0 1\nend\n"
    low, high = surface.format(1, "1 2 3 4"), surface.format(2, "1 2 3 4 5 6")
    parts = [("c", curve), ("high", high), ("low", low), ("c", curve), ("low", low), ("high", high)]
    text = (
        write_points()
        + "cstype bezier\n"
        + "".join(f"usemtl {name}{i}\n{part}" for i, (name, part) in enumerate(parts))
    )
    mesh = load(text, 1.0)
    sizes = np.diff(mesh.offsets)
    material = mesh.attributes.face["material"]
    names = [mesh.attributes.labels["material"][int(value)] for value in material]
    assert list(dict.fromkeys(names)) == ["c0", "high1", "low2", "c3", "low4", "high5"]
    assert [int(size) for size in sizes] == [2 if name[0] == "c" else 4 for name in names]


def test_patches_with_and_without_weights_are_welded() -> None:
    """A plane, and a quarter of a cylinder beside it."""
    h = math.sqrt(0.5)
    points = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 2), (1, 1, 2), (0, 1, 2), (1, -3, 0), (1, -3, 2)]
    weights = [1, h, 1, 1, h, 1, 1, 1]
    vertices = "".join(f"v {x} {y} {z} {w}\n" for (x, y, z), w in zip(points, weights, strict=True))
    parms = "parm u 0 1\nparm v 0 1\nend\n"
    text = f"{vertices}cstype bezier\ndeg 1 1\nsurf 0 1 0 1 7 1 8 4\n{parms}"
    text += f"cstype rat bezier\ndeg 2 1\nsurf 0 1 0 1 1 2 3 4 5 6\n{parms}"
    mesh = load(text, 0.01)
    n = round(math.sqrt(mesh.n_faces / 2))
    assert mesh.n_points == (n + 1) * (2 * n + 1)
    curved = np.asarray(mesh.faces)[n * n :]
    np.testing.assert_allclose(np.linalg.norm(mesh.positions[curved][..., :2], axis=-1), 1, rtol=0, atol=1e-15)
    np.testing.assert_allclose(mesh.attributes.corner["normal"][: 4 * n * n], np.tile([1.0, 0, 0], (4 * n * n, 1)))


B_SPLINE = "".join(f"v {x} {y} {(x - y) ** 2}\n" for y in range(4) for x in range(4))


def test_the_old_b_spline_patch_is_the_uniform_one() -> None:
    names = " ".join(map(str, range(1, 17)))
    old = load(f"{B_SPLINE}bsp {names}\n", 0.01)
    knots = "0 1 2 3 4 5 6 7"
    new = load(f"{B_SPLINE}cstype bspline\ndeg 3 3\nsurf 3 4 3 4 {names}\nparm u {knots}\nparm v {knots}\nend\n", 0.01)
    assert old.n_faces == new.n_faces
    np.testing.assert_allclose(old.positions, new.positions, rtol=0, atol=1e-15)
    np.testing.assert_allclose(old.bounds[:, :2], [[1, 1], [2, 2]], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("statements", "reason"),
    [
        ("bzp 1 2 3", "line 17: bzp needs 16 points, got 3"),
        ("cdc 1 2 3 4", "line 17: cdc of type none is none of curv and surf of bezier and bspline"),
        ("cstype bezier\ndeg 3\ncurv 0 1 1 2 3\nparm u 0 1\nend", "line 19: curv needs 4 control points for its"),
        ("cstype bezier\ndeg 3\ncurv 0 1 1 2 3 99\nparm u 0 1\nend", "line 19: curv names point 99, and there are 16"),
        ("cstype bezier\ndeg 3\ncurv 0 x 1 2 3 4\nparm u 0 1\nend", "line 19: could not convert string to float: 'x'"),
        ("cstype bezier\ndeg 3\ncurv 0 inf 1 2 3 4\nparm u 0 1\nend", "line 19: expected a finite number, got inf"),
        (
            "cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1!\nend",
            "line 19: could not convert string to float: '1!'",
        ),
        ("cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 1 0\nend", "line 19: parm must ascend"),
        ("cstype bezier\ndeg 3\ncurv 5 6 1 2 3 4\nparm u 0 1\nend", "line 19: curv has nothing between its ends"),
        (
            "cstype bezier\ncurv 0 1 1 2 3 4\nparm u 0 1\nend",
            "line 18: curv needs deg with 1 degree of 1 to 11, got none",
        ),
        *(
            (
                f"cstype bezier\ndeg {words}\n{form} 0 1 1 2 3 4\nparm u 0 1\nend",
                f"line 19: {form} needs deg with {expected} of 1 to 11, got {got!r}",
            )
            for form, words, expected, got in (
                ("curv", "x", "1 degree", "x"),
                ("curv", "1e9 3", "1 degree", "1e9"),
                ("curv", "-1", "1 degree", "-1"),
                ("curv", "0", "1 degree", "0"),
                ("curv", "12", "1 degree", "12"),
                ("curv", "3.0", "1 degree", "3.0"),
                ("curv", "3" * 5000, "1 degree", "3" * 37 + "..."),
                ("surf", "3", "2 degrees", "3"),
                ("surf", "3 x 1", "2 degrees", "3 x"),
            )
        ),
        ("cstype bspline\ndeg 1\ncurv 0 1 1 2 3 4\nparm u 0 2 1 3 4 5\nend", "line 19: parm must not descend, got 2"),
        ("cstype bmatrix\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1", "line 19: curv of type bmatrix is none of curv and"),
    ],
)
def test_forms_that_cannot_be_read_are_left_out_with_the_reason(statements: str, reason: str) -> None:
    keyword = next(word for word in ("bzp", "cdc", "curv", "surf") if word in statements)
    with pytest.warns(gx.MeshWarning, match=re.escape(f"not shown: 1 {keyword}; {reason}")):
        mesh = load(f"{B_SPLINE}{statements}\nf 1 2 3\n")
    assert (mesh.n_points, mesh.n_faces) == (16, 1)


@pytest.mark.parametrize("word", ["3" * 5_000, "3 " + "3" * 5_000, "9" * 10])
def test_a_degree_beyond_all_numbers_shows_nothing(word: str) -> None:
    body = f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ncstype bezier\ndeg {word}\nsurf 0 1 0 1 1 2 3\nparm u 0 1\nend\n"
    with pytest.warns(gx.MeshWarning, match="not shown: 1 surf"):
        assert load(body).n_faces == 1


@pytest.mark.parametrize("end", ["", "f 1 2 \\\n3\n"], ids=["in blocks", "by lines"])
def test_only_what_is_not_drawn_is_left_out(end: str) -> None:
    drawn = write_patches("bezier") + "curv 0 1 1 2 3 4\nparm u 0 1\nend\n"
    assert "left_out" not in load(drawn + end, 0.1).metadata.get("obj", {})
    others = "cstype taylor\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\nlod 3\ncon 1 0 1 1 2 0 1 1\n"
    with pytest.warns(gx.MeshWarning, match="not shown: 1 curv; line"):
        mesh = load(f"{drawn}{others}{end}", 0.1)
    assert sorted(", ".join(mesh.metadata["obj"]["left_out"]).split(", ")) == ["1 con", "1 curv", "1 lod"]


def test_what_is_trimmed_is_named() -> None:
    names = " ".join(map(str, range(1, 17)))
    knots = "0 0 0 0 1 1 1 1"
    body = f"cstype bspline\ndeg 3 3\nsurf 0 1 0 1 {names}\nparm u {knots}\nparm v {knots}\ntrim 0 1 1\nend\n"
    with pytest.warns(gx.MeshWarning, match="not shown: 1 trim$"):
        mesh = load(B_SPLINE + body, 0.1)
    assert mesh.n_faces > 1
    assert mesh.metadata["obj"]["left_out"] == ("1 trim",)


@pytest.mark.parametrize(
    ("tolerance", "message"),
    [
        (0, r"tolerance must be positive, got 0\.0"),
        (math.nan, "tolerance must be finite, got nan"),
        (1e-12, "tolerance must need at most 16777216 faces, got 1e-12"),
    ],
)
def test_bad_tolerances_are_refused(tolerance: float, message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        load(write_patches("bzp"), tolerance)


def test_other_formats_take_a_tolerance_too(tmp_path: Any) -> None:
    gx.save_mesh(gx.samples.house(), tmp_path / "house.ply")
    assert gx.load_mesh(tmp_path / "house.ply", tolerance=1) == gx.samples.house()
    (tmp_path / "teapot.obj").write_text(write_patches("bzp"))
    scene = gx.load_scene(tmp_path / "teapot.obj", tolerance=0.1)
    assert scene["teapot"].models[0].model == gx.load_mesh(tmp_path / "teapot.obj", tolerance=0.1)


def test_many_curves_take_little_memory() -> None:
    """Before, a megabyte of curves took 261 MiB: rows of NaN for normals, references to nothing, all that was read."""
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\ncstype bezier\ndeg 2\n" + "curv 0 1 1 2 3\nparm u 0 1\nend\n" * 500
    load(text)
    tracemalloc.start()
    try:
        mesh = load(text)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 260 * mesh.n_faces


@pytest.mark.parametrize("kind", ["bspline", "bezier"])
def test_one_long_curve_costs_little(kind: str) -> None:
    """Before, 60 kB of a B-spline took gigabytes and hours: the matrix of all its points for each knot."""
    n = 3001
    knots = " ".join(map(str, range(n + 4 if kind == "bspline" else (n - 1) // 3 + 1)))
    text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\ncstype {kind}\ndeg 3\ncurv 0 {n} {'1 2 3 ' * (n // 3)}1\nparm u {knots}\nend\n"
    for _ in within_cpu_s(1):
        assert load(text).n_faces > n // 3


@pytest.mark.parametrize("kind", ["bspline", "bezier"])
def test_a_degree_that_no_program_writes_is_left_out(kind: str) -> None:
    """Before, a curve of degree 20,000 did not end."""
    knots = "0 1" if kind == "bezier" else "0 " * 20_001 + "1 " * 20_001
    body = f"cstype {kind}\ndeg 20000\ncurv 0 1 {'1 ' * 20_001}\nparm u {knots}\nend\n"
    with pytest.warns(
        gx.MeshWarning, match=r"not shown: 1 curv; line 6: curv needs deg with 1 degree of 1 to 11, got '20000'$"
    ):
        assert load(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{body}f 1 2 3\n").n_faces == 1


def test_the_default_tolerance_never_needs_too_many_faces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, this was an ArgumentError about a tolerance that nobody gave."""
    monkeypatch.setattr(obj_free_forms, "_MAX_DEFAULT_SEGMENTS", 1024)
    vertices = "".join(f"v {i % 3} {i // 3} {i % 2} {10.0 ** (i % 5 * 3 - 6)}\n" for i in range(9))
    body = "cstype rat bezier\ndeg 2 2\nsurf 0 1 0 1 1 2 3 4 5 6 7 8 9\nparm u 0 1\nparm v 0 1\nend\n"
    with pytest.warns(gx.MeshWarning, match="line 12: surf and others are drawn coarser than usual, in 16 steps"):
        assert load(vertices + body).n_faces == 16**2


PARMS = "parm u 0 1\nparm v 0 1\nend\n"


def write_points(*, rational: bool = False, n: int = 9) -> str:
    """Return the points of the bodies below, no four in a plane."""
    rng = np.random.default_rng(n)
    rows = rng.uniform(0.5, 9.5, (n, 4 if rational else 3)).tolist()
    return "".join(f"v {' '.join(f'{value:.2f}' for value in row)}\n" for row in rows)


def write_names(count: int) -> str:
    return " ".join(str(i * (i + 3) // 2 % 9 + 1) for i in range(count))


def write_bodies() -> dict[str, str]:
    """Return texts of 20 kB, or 70 of many small forms, that took seconds, or hundreds of megabytes, per megabyte."""
    size, of_many = 20_000, 70_000
    rational, plain = write_points(rational=True), write_points()
    high = f"deg 11 11\nsurf 0 1 0 1 {write_names(144)}\n{PARMS}"
    low = f"surf 0 1 0 1 1 2 3 4\n{PARMS}"
    n_low = size // len(low)
    turns = "".join(
        f"deg {i} {i % 3 + 1}\nsurf 0 1 0 1 {write_names((i + 1) * (i % 3 + 2))}\n{PARMS}" for i in range(1, 12)
    )
    line = "".join(f"v {i} {2 * i} {3 * i}\n" for i in range(1, 10))
    return {
        "rational patches": f"{rational}cstype rat bezier\ndeg 1 1\n{low * n_low}",
        "patches beside one of degree 11": f"{rational}cstype rat bezier\n{high}cstype bezier\ndeg 1 1\n{low * n_low}",
        "rational patches of degree 11": f"{rational}cstype rat bezier\n{high * (size // len(high))}",
        "patches without area": f"{line}cstype bezier\n{high * (size // len(high))}",
        "degrees in turn": f"{plain}cstype bezier\n" + turns * (size // len(turns)),
        "old splines": plain + f"bsp {write_names(16)}\n" * (of_many // 36),
        "curves cut elsewhere": f"{plain}cstype bezier\ndeg 11\n"
        + "".join(f"curv {i / 1e4:g} 1 {write_names(12)}\nparm u 0 1\nend\n" for i in range(of_many // 50)),
    }


@pytest.mark.filterwarnings("ignore::gpu_xform.MeshWarning")
@pytest.mark.parametrize("name", write_bodies())
def test_bodies_of_free_forms_end_soon_and_in_little_memory(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, a megabyte of each took 4 to 35 s of a processor, or 1 to 5 GB."""
    monkeypatch.setattr(obj_free_forms, "_MAX_DEFAULT_SEGMENTS", 1 << 14)
    text = write_bodies()[name]
    load(f"{write_points(rational=True)}cstype rat bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\n{PARMS}")
    for _ in within_cpu_s(0.15):
        load(text)
    tracemalloc.start()
    try:
        mesh = load(text)
        assert tracemalloc.get_traced_memory()[1] < 10e6 + 400 * mesh.n_faces
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("rational", [False, True])
def test_a_b_spline_that_names_few_points_often_expands_only_so_far(rational: bool) -> None:
    """Before, a megabyte of this kind took more than 12 GB."""
    n, degree = 200, 11
    knots = " ".join(map(str, range(n + degree + 1)))
    statements = f"surf 0 999 0 999 {write_names(n * n)}\nparm u {knots}\nparm v {knots}\nend\n"
    text = f"{write_points(rational=rational)}cstype {'rat ' * rational}bspline\ndeg {degree} {degree}\n{statements}"
    with pytest.raises(
        gx.MeshError, match=r"line 12: expands to more than [\d,]+ points of 16 numbers, the limit FileLimits\(points"
    ):
        load(text)


@pytest.mark.parametrize("weight", ["", " 1.5"])
def test_points_that_overflow_are_refused(weight: str) -> None:
    """Before, NumPy warned, and the points of the mesh were no numbers."""
    points = "".join(f"v {row}{weight}\n" for row in ("1e308 0 0", "0 1e308 0", "-1e308 0 3", "0 0 1.7e308"))
    text = f"{points}cstype {'rat ' if weight else ''}bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\n{PARMS}"
    if not weight:
        assert load(text).n_points == 4
        return
    with pytest.warns(gx.MeshWarning, match="line 7: surf has points that overflow when they are multiplied by their"):
        load(text + "f 1 2 3\n")


def test_points_that_rounding_takes_beyond_all_numbers_are_refused() -> None:
    most = sys.float_info.max
    points = "".join(f"v {most} {most} {i} 0.3\n" for i in range(16))
    text = f"{points}cstype rat bezier\ndeg 3 3\nsurf 0 1 0 1 {' '.join(map(str, range(1, 17)))}\n{PARMS}"
    with (
        pytest.warns(gx.MeshWarning, match="coarser"),
        pytest.raises(gx.MeshError, match="line 19: the points of surf and others overflow"),
    ):
        load(text)


@pytest.mark.parametrize("form", ["curv 0 1 1 2", "surf 0 1 0 1 1 2 3 4"])
def test_parameters_that_are_too_far_apart_are_left_out(form: str) -> None:
    """Before, they were a ZeroDivisionError, and NumPy warned."""
    knots = "-1e308 -1e308 1e308 1e308"
    text = f"{write_points()}cstype bspline\ndeg 1 1\n{form}\nparm u {knots}\nparm v {knots}\nend\nf 1 2 3\n"
    with pytest.warns(gx.MeshWarning, match="parm reaches from -1e\\+308 to 1e\\+308, which are too far apart"):
        assert load(text).n_faces == 1


@pytest.mark.parametrize("size", ["1", "1e155", "1e300"])
def test_the_default_tolerance_is_that_of_points_of_any_size(size: str) -> None:
    """Before, squares of points beyond 1e154 overflowed: a curve had half a million segments."""
    points = f"v {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\n"
    mesh = load(f"{points}cstype bezier\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 1\nend\n")
    # The second derivative is 2 (1, -2, 1), and the diagonal of the points (1, 1, 1).
    assert mesh.n_faces == math.ceil(math.sqrt(2 * math.sqrt(6) / (8 * 1e-3 * math.sqrt(3))))
