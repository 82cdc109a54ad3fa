import dataclasses
import io
import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from gpu_xform import Camera, Mesh, matrices, render_array, render_pdf, render_svg, samples, save_mesh
from gpu_xform.cli import main
from gpu_xform.cli.options import STYLE
from gpu_xform.drawing.layer import Layer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.imaging.colors import COLOR_CYCLE
from tests.support.cli import error_of, read_png, run_in_process
from tests.support.types import Pixels

SIZE = ("--resolution", "120,80")


@pytest.fixture(autouse=True)
def _files() -> None:
    save_mesh(samples.house(), "house.obj")


def run_render(*options: str, model: str = "house.obj") -> Pixels:
    assert main(["render", model, "-o", "out.png", *options]) == 0
    return read_png("out.png")


def expected(**arguments: Any) -> Pixels:
    return render_array(samples.house(), size=(120, 80), **arguments)


def test_the_corners_of_the_model_are_lit_and_the_frame_is_not() -> None:
    pixels = run_render("--resolution", "200,150", "--camera-position", "3,4,9", "--line-width", "3")
    assert pixels.shape == (150, 200, 4)
    # By hand: the view's axes, the distance along it, 15 degrees to the picture's upper edge.
    eye = np.array([3.0, 4.0, 9.0])
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    away = samples.house().positions - eye
    half_height = (away @ forward) * np.tan(np.radians(15))
    x = 100 + 75 * (away @ right) / half_height
    y = 75 - 75 * (away @ up) / half_height
    assert x.min() > 2
    assert x.max() < 198
    assert (pixels[y.astype(int), x.astype(int), :3] < 32).all()
    assert (pixels[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ([], {}),
        (
            ["--rotate-y", "-30", "--scale", "1,2,1"],
            {"transform": matrices.scale(1, 2, 1) @ matrices.rotate_y(-np.pi / 6)},
        ),
        (["--perspective-from-eye", "3"], {"transform": matrices.perspective_from_eye(3)}),
        (["--line-width", "7.5"], {"line_width": 7.5}),
        (["--color", "face"], {"color": "face"}),
        (["--color", "tomato"], {"color": "tomato"}),
        (["--color", "1,0.5,0"], {"color": (1, 0.5, 0)}),
        (["--color", "1 0.5 0"], {"color": (1, 0.5, 0)}),
        (["--color", "0.5"], {"color": "0.5"}),
        (["--color", "rgb(255, 0, 0)"], {"color": "#ff0000"}),
        (["--edges", "silhouette"], {"edges": "silhouette"}),
        (["--edges", "silhouette, boundary"], {"edges": ["silhouette", "boundary"]}),
        (["--edges", "feature", "--feature-angle", "60"], {"edges": "feature", "feature_angle": 60}),
        (["--hidden", "remove"], {"hidden": "remove"}),
        (["--hidden", "dash"], {"hidden": "dash"}),
        (["--hidden", "fade"], {"hidden": "fade"}),
        (["--fill", "khaki"], {"fill": "khaki"}),
        (["--fill", "face"], {"fill": "face"}),
        (["--fill", "0.9,0.9,1", "--hidden", "show"], {"fill": (0.9, 0.9, 1), "hidden": "show"}),
        (["--alpha", "0.25"], {"alpha": 0.25}),
        (["--depth-cue", "0.75"], {"depth_cue": 0.75}),
        (["--point-size", "6.5"], {"point_size": 6.5}),
        (["--no-antialias"], {"antialias": False}),
        (["--background-color", "#123456"], {"background": "#123456"}),
        (["--no-background"], {"background": None}),
        (["--camera-direction", "-Z"], {"camera": Camera.fit(samples.house(), direction=(0, 0, -1))}),
        # Turned to the right and raised, as VTK's camera and so F3D's is.
        (
            ["--camera-direction", "-Z", "--camera-azimuth-angle", "90"],
            {"camera": Camera.fit(samples.house(), direction=(-1, 0, 0))},
        ),
        (
            ["--camera-direction", "-Z", "--camera-elevation-angle", "90"],
            {"camera": Camera.fit(samples.house(), direction=(0, -1, 0), up=(0, 0, -1))},
        ),
        (
            ["--camera-position", "0,0,9", "--camera-azimuth-angle", "90", "--camera-elevation-angle", "30"],
            {"camera": Camera.look_at((9 * math.cos(math.pi / 6), 4.5, 0), (0, 0, 0))},
        ),
        (["--camera-zoom-factor", "0.5"], {"camera": {"margin": 0.25}}),
        (["--camera-zoom-factor", "1.5"], {"camera": {"margin": -0.25}}),
        (
            ["--camera-direction=0,-1,0", "--camera-view-up", "-Z", "--camera-orthographic"],
            {"camera": Camera.fit(samples.house(), direction=(0, -1, 0), up=(0, 0, -1), orthographic=True)},
        ),
        (["--background", "navy"], {"background": "navy"}),
        (["--fov", "60"], {"camera": {"fov_y": 60}}),
        (["--camera-view-angle", "60"], {"camera": Camera.fit(samples.house(), fov_y=60)}),
        (
            ["--camera-position", "-3,4,5", "--camera-focal-point", "-1,0,.5", "--camera-view-angle", "50"],
            {"camera": Camera.look_at((-3, 4, 5), (-1, 0, 0.5), fov_y=50)},
        ),
        (
            ["--translate", "1,2,3", "--camera-position", "9,9,9"],
            {"transform": matrices.translate(1, 2, 3), "camera": Camera.look_at((9, 9, 9), (1, 2, 3))},
        ),
        (
            ["--camera-position", "-3,4,5", "--camera-orthographic", "--up", "x"],
            {"camera": Camera.look_at((-3, 4, 5), (0, 0, 0), (1, 0, 0), orthographic=True)},
        ),
    ],
)
def test_options_are_the_library_s_arguments(options: list[str], arguments: dict[str, Any]) -> None:
    pixels = run_render(*SIZE, *options)
    assert np.array_equal(pixels, expected(**arguments))
    assert not options or not np.array_equal(pixels, expected())


def test_no_background_is_transparent_between_the_lines() -> None:
    alpha = run_render(*SIZE, "--no-background")[..., 3]
    assert (alpha[[0, 0, -1, -1], [0, -1, 0, -1]] == 0).all()
    assert alpha.max() == 255


def test_one_color_for_each_face() -> None:
    pixels = run_render("--resolution", "300x300", "--color", "face", "--line-width", "4")
    colors = {"#" + bytes(color).hex() for color in pixels[..., :3].reshape(-1, 3)}
    # Later faces cover the edges they share with earlier ones: the two gables come first, and have none left.
    assert [cycled in colors for cycled in COLOR_CYCLE] == 2 * [False] + 5 * [True] + 3 * [False]


@pytest.mark.parametrize("typed", ["30,20", "30x20", "30X20", " 30 , 20 "])
def test_a_resolution_is_width_and_height(typed: str) -> None:
    assert run_render("--resolution", typed).shape == (20, 30, 4)


def test_the_default_picture_is_1024_square_and_black_on_white() -> None:
    pixels = run_render()
    assert np.array_equal(pixels, render_array(samples.house()))
    assert pixels.shape == (1024, 1024, 4)


@pytest.mark.parametrize(
    ("up", "world_from_upright"),
    [
        ("+Z", matrices.rotate_x(90, degrees=True)),
        ("-Z", matrices.rotate_x(-90, degrees=True)),
        ("x", matrices.rotate_z(-90, degrees=True)),
        ("-X", matrices.rotate_z(90, degrees=True)),
        ("-y", matrices.rotate_x(180, degrees=True)),
        ("0,3e5,3e5", matrices.rotate_x(45, degrees=True)),
    ],
)
def test_a_model_with_another_up_looks_the_same(up: str, world_from_upright: npt.NDArray[np.float64]) -> None:
    save_mesh(samples.house().transformed(world_from_upright), "lying.obj")
    difference = np.abs(run_render(*SIZE, "--up", up, model="lying.obj").astype(int) - expected())
    assert difference.max() <= 2
    assert np.abs(run_render(*SIZE, model="lying.obj").astype(int) - expected()).max() > 200


@pytest.mark.slow
def test_standard_output_holds_the_picture_and_nothing_else(capsysbinary: pytest.CaptureFixture[bytes]) -> None:
    typed = ["render", "-", "--file-type", "OBJ", "-o", "-", *SIZE]
    result = run_in_process(*typed, input=Path("house.obj").read_bytes())
    assert (result.returncode, result.stderr) == (0, b"")
    with Image.open(io.BytesIO(result.stdout)) as image:
        assert np.array_equal(np.asarray(image), expected())
    assert result.stdout.endswith(b"IEND\xaeB`\x82")
    assert main(["render", "house.obj", "-o", "-", *SIZE]) == 0
    assert capsysbinary.readouterr() == (result.stdout, b"")
    assert list(Path().iterdir()) == [Path("house.obj")]


def test_a_part_of_the_adapter_s_name_picks_it(device: GpuDevice) -> None:
    assert np.array_equal(run_render(*SIZE, "--adapter", device.name[1:5].upper()), expected())


def test_an_older_picture_is_replaced() -> None:
    Path("out.png").write_bytes(b"older")
    Path("OTHER.PNG").write_bytes(b"older")
    run_render(*SIZE)
    assert main(["render", "house.obj", "-o", "OTHER.PNG", *SIZE]) == 0
    assert Path("OTHER.PNG").read_bytes() == Path("out.png").read_bytes()
    assert len(list(Path().iterdir())) == 3


def test_a_type_may_be_said_for_a_name_that_does_not_say_it() -> None:
    Path("house.obj").rename("house.txt")
    assert np.array_equal(run_render(*SIZE, "--file-type", ".obj", model="house.txt"), expected())


def test_points_behind_a_projection_s_eye_are_not_framed() -> None:
    save_mesh(Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 50)], [(0, 1, 2)]), "point.obj")
    options = [*SIZE, "--perspective-from-eye", "5", "--camera-direction", "-Z"]
    triangle = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    camera = Camera.fit(triangle, direction=(0, 0, -1))
    assert np.array_equal(
        run_render(*options, model="point.obj"), render_array(triangle, size=(120, 80), camera=camera)
    )


@pytest.mark.slow
def test_edges_are_chosen_by_name() -> None:
    house = samples.house()
    split = Mesh(house.positions, house.to_trimesh().faces)
    save_mesh(split, "split.obj")
    assert np.array_equal(run_render("--edges", "feature", model="split.obj"), run_render())
    assert not np.array_equal(run_render(model="split.obj"), run_render())
    # The walls stand at right angles; nothing else turns as far.
    sharp, some = run_render("--edges", "feature", "--feature-angle", "89", model="split.obj"), run_render()
    assert (sharp != some).any()
    assert ((sharp == some) | (sharp == 255)).mean() > 0.98
    save_mesh(samples.grid(3), "grid.obj")
    rim = run_render("--edges", "boundary", model="grid.obj")
    assert np.array_equal(run_render("--edges", "boundary,feature", model="grid.obj"), rim)
    assert not np.array_equal(run_render(model="grid.obj"), rim)


@pytest.mark.parametrize("options", [["--edges", "creases"], ["--feature-angle", "181"], ["--feature-angle", "x"]])
def test_edges_that_are_none_are_refused(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert options[0] in error_of(["render", "house.obj", "-o", "out.png", *options], capsys)
    assert not Path("out.png").exists()


def test_sets_of_edges_may_be_named_one_by_one() -> None:
    both = run_render("--edges", "feature", "--edges", "silhouette", "--size", "60,40")
    assert np.array_equal(both, run_render("--edges", "feature,silhouette", "--size", "60,40"))
    assert not np.array_equal(both, run_render("--edges", "silhouette", "--size", "60,40"))


def test_views_on_one_sheet(capsys: pytest.CaptureFixture[str]) -> None:
    views = ["--views", "front,top,right,iso", "--projection", "first", "--size", "120,80"]
    expected = render_array(samples.house(), size=(120, 80), views="front,top,right,iso", projection="first")
    assert np.array_equal(run_render(*views), expected)
    for options, message in (
        (["--views", "side"], "--views: expected names among"),
        (["--projection", "first"], "--projection must come with --views"),
        (["--views", "front", "--camera-direction", "x"], "--camera-direction cannot go with --views"),
        (["--views", "front", "--camera-elevation-angle", "3"], "--camera-elevation-angle cannot go with --views"),
    ):
        assert message in error_of(["render", "house.obj", "-o", "out.png", *options], capsys)


def test_the_help_names_the_library_s_defaults() -> None:
    defaults = {field.name: field.default for field in dataclasses.fields(Layer)}
    in_words = {
        "edges": "all",
        "hidden": "show, but behind opaque faces of another layer or with --fill remove",
        "fill": "no fill",
        "dash": "continuous",
    }
    in_words |= {
        "clim": "the smallest and the largest",
        "max_points": "all",
        "point_size": "none; 2 for models without edges",
    }
    for flag, _, _, text in STYLE:
        name = flag.removeprefix("--").replace("-", "_")
        said = re.search(r"\(default: (.*)\)", text)
        if name in in_words:
            assert defaults[name] is None
            assert said is not None
            assert said[1] == in_words[name]
        elif said is None:
            assert defaults[name] is None
        else:
            assert said[1] == (f"{defaults[name]:g}" if isinstance(defaults[name], float) else defaults[name])


def test_every_keyword_that_is_no_array_is_an_option() -> None:
    options = {flag.removeprefix("--").replace("-", "_") for flag, *_ in STYLE}
    arrays = {"face_colors", "edge_colors", "vertex_colors"}
    elsewhere = {"model", "transform", "name", "antialias", "colorbar"}
    assert options | arrays | elsewhere == {field.name for field in dataclasses.fields(Layer)}


STYLED = ["--edges", "feature", "--hidden", "dash", "--fill", "khaki", "--rotate-y", "20", "--background-color", "snow"]


@pytest.mark.parametrize("kind", ["svg", "pdf", "SVG"])
@pytest.mark.parametrize("to", ["house.{}", "drawn/{{model}}.{}"])
def test_a_document_by_its_name(kind: str, to: str) -> None:
    path = to.format(kind)
    assert main(["render", "house.obj", "-o", path, *SIZE, *STYLED]) == 0
    draw = {"svg": render_svg, "pdf": render_pdf}[kind.lower()]
    document = draw(
        Layer(
            samples.house(),
            name="house",
            transform=matrices.rotate_y(20, degrees=True),
            edges="feature",
            hidden="dash",
            fill="khaki",
        ),
        size=(120, 80),
        background="snow",
    )
    written = Path(path.format(model="house")).read_bytes()
    assert written == (document.encode() if isinstance(document, str) else document)
    assert written.startswith(b"<svg" if kind.lower() == "svg" else b"%PDF")


def test_a_document_of_two_models_has_a_group_of_each() -> None:
    save_mesh(samples.cube(), "box.obj")
    assert main(["render", "house.obj", "box.obj", "-o", "both.svg"]) == 0
    assert re.findall(r'<g[^>]*id="([^"]*)"', Path("both.svg").read_text("utf-8"))[:2] == ["house", "box"]


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["-o", "x.svg", "--reference", "out.png"], "x.svg: only a .png can be compared with a --reference"),
        (["-o", "x.png", "--reference", "out.png", "--reference-diff", "d.svg"], "d.svg: the type must be one of png"),
        (["-o", "x.bmp"], "x.bmp: the type must be one of png, svg, pdf, html, htm, got bmp"),
    ],
)
def test_documents_are_not_compared(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in error_of(["render", "house.obj", *typed], capsys)
    assert sorted(path.name for path in Path().iterdir()) == ["house.obj"]


def test_without_the_extra_a_pdf_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pydyf", None)
    assert "pip install 'gpu_xform[pdf]'" in error_of(["render", "house.obj", "-o", "house.pdf", *SIZE], capsys)
    assert not Path("house.pdf").exists()


HEIGHTS = np.sin(np.arange(10.0))


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        (["--scalars", "y"], {"scalars": samples.house().positions[:, 1]}),
        (["--scalars", "x", "--rotate-y", "90"], {"scalars": samples.house().positions[:, 0]}),
        (["--scalars", "heights.npy"], {"scalars": HEIGHTS}),
        (["--scalars", "{folder}/{model}.npy"], {"scalars": -HEIGHTS}),
        (["--scalars", "heights.npy", "--cmap", "plasma_r"], {"scalars": HEIGHTS, "cmap": "plasma_r"}),
        (["--scalars", "heights.npy", "--clim", "-2,0.5"], {"scalars": HEIGHTS, "clim": (-2, 0.5)}),
    ],
)
def test_colours_by_number(options: list[str], arguments: dict[str, Any]) -> None:
    np.save("heights.npy", HEIGHTS.astype(">f8"))
    np.save("house.npy", -HEIGHTS)
    if "--rotate-y" in options:
        arguments = arguments | {"transform": matrices.rotate_y(90, degrees=True)}
    pixels = run_render(*SIZE, *options)
    assert np.array_equal(pixels, expected(**arguments))
    plain = {name: value for name, value in arguments.items() if name in {"transform", "scalars"}}
    assert len(arguments) == len(plain) or not np.array_equal(pixels, expected(**plain))


def test_one_colour_means_one_number_in_a_picture_of_two_models() -> None:
    house, tower = samples.house(), samples.house().transformed(matrices.scale(1, 3, 1))
    save_mesh(tower, "tower.obj")
    assert main(["render", "house.obj", "tower.obj", "-o", "out.png", *SIZE, "--scalars", "y"]) == 0
    y = [mesh.positions[:, 1] for mesh in (house, tower)]
    ends = min(y[0].min(), y[1].min()), max(y[0].max(), y[1].max())
    together = [Layer(house, scalars=y[0], clim=ends), Layer(tower, scalars=y[1], clim=ends)]
    assert np.array_equal(read_png("out.png"), render_array(together, size=(120, 80)))
    apart = [Layer(house, scalars=y[0]), Layer(tower, scalars=y[1])]
    assert not np.array_equal(render_array(together, size=(120, 80)), render_array(apart, size=(120, 80)))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ["--scalars", "w"],
            "--scalars: expected x, y, z, an .npy file, or an attribute, of which house.obj",
        ),
        (["--scalars", "none.npy"], "none.npy: No such file"),
        (
            ["--scalars", "nine.npy"],
            "nine.npy: expected one number for each of the 10 points of house.obj, got shape (9,)",
        ),
        (["--scalars", "words.npy"], "words.npy must hold real numbers"),
        (["--scalars", "infinite.npy"], "scalars must be finite"),
        (["--scalars", "{name}.npy"], "expected {model}, {suffix}, {parent} or {folder}, or"),
        (["--scalars", "x", "--color", "red"], "not allowed with"),
        (["--scalars", "x", "--cmap", "nonesuch"], "--cmap: cmap must be a colormap's name"),
        (["--scalars", "x", "--clim", "2,1"], "--clim: expected two numbers, the lower first"),
        (["--scalars", "x", "--clim", "nan,1"], "--clim: expected two numbers, the lower first"),
        (["--scalars", "x", "--clim", "0,inf"], "--clim: expected two numbers, the lower first"),
        (["--scalars", "x", "--clim", "0"], "--clim: expected two numbers"),
        (["--cmap", "viridis"], "--cmap must come with --scalars"),
        (["--clim", "0,1"], "--clim must come with --scalars"),
        (["--hidden", "blur"], "--hidden: expected show, remove, dash, fade, got 'blur'"),
        (["--alpha", "1.1"], "--alpha: expected a number from 0 to 1"),
        (["--depth-cue", "nan"], "--depth-cue: expected a number from 0 to 1"),
        (["--point-size", "0"], "--point-size: expected a positive number of pixels"),
        (["--fill", "blurple"], "--fill"),
        (["--color", "face", "--edges", "feature"], "edges must be 'all' if each face has its own colour"),
    ],
)
def test_styles_that_cannot_be(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    np.save("nine.npy", np.zeros(9))
    np.save("words.npy", np.full(10, "a"))
    np.save("infinite.npy", np.full(10, np.inf))
    message = error_of(["render", "house.obj", "-o", "out.png", *options], capsys)
    assert words in message
    assert not Path("out.png").exists()


ROWS = np.random.default_rng(2).uniform(0, 1, (20, 4))
ROWS[:, 3] = 1.0
PAIRS = np.array([(0, 3), (2, 7), (9, 1)])
PLACES = np.stack([matrices.translate(1.5 * k, 0.2 * k, -k) @ matrices.rotate_y(0.3 * k) for k in range(3)])
N_FACES, N_EDGES, N_POINTS = samples.house().n_faces, len(samples.house().edges), samples.house().n_points


@pytest.fixture
def arrays() -> None:
    for name, n in (("faces", N_FACES), ("edges", N_EDGES), ("points", N_POINTS)):
        np.save(f"{name}.npy", ROWS[:n])
    np.save("house.npy", ROWS[:N_EDGES, :3])
    np.save("pairs.npy", PAIRS)
    np.save("places.npy", PLACES)
    np.save("heights.npy", HEIGHTS)
    np.save("no_places.npy", PLACES[:0])
    np.save("no_pairs.npy", PAIRS[:0])


@pytest.mark.usefixtures("arrays")
@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        (["--face-colors", "faces.npy"], {"face_colors": ROWS[:N_FACES]}),
        (["--edge-colors", "edges.npy"], {"edge_colors": ROWS[:N_EDGES]}),
        (["--edge-colors", "{model}.npy"], {"edge_colors": ROWS[:N_EDGES, :3]}),
        (["--vertex-colors", "points.npy"], {"vertex_colors": ROWS[:N_POINTS]}),
        (["--fill", "faces.npy"], {"fill": ROWS[:N_FACES]}),
        (["--edges", "pairs.npy"], {"edges": PAIRS}),
        (["--edges", "boundary,pairs.npy,silhouette"], {"edges": ["boundary", PAIRS, "silhouette"]}),
        (["--instances", "places.npy"], {"transform": PLACES}),
        (["--instances", "places.npy", "--scale", "1,2,3"], {"transform": matrices.scale(1, 2, 3) @ PLACES}),
        (
            ["--instances", "places.npy", "--scalars", "y"],
            {"transform": PLACES, "scalars": samples.house().positions[:, 1]},
        ),
    ],
)
def test_arrays_are_what_the_library_takes(options: list[str], arguments: dict[str, Any]) -> None:
    pixels = run_render(*SIZE, *options)
    assert np.array_equal(pixels, expected(**arguments))
    assert not np.array_equal(pixels, expected())


@pytest.mark.usefixtures("arrays")
def test_extra_layers_have_their_own_style() -> None:
    save_mesh(samples.cube(), "a cube.obj")
    shown = run_render(
        *SIZE,
        "--fill",
        "gold",
        "--layer",
        "'a cube.obj' --translate -2,0,1 --rotate-x 20 --hidden dash --color red",
        "--layer",
        "house.obj --scalars y --instances places.npy --rotate-z -90",
    )
    aside = matrices.chain(matrices.translate(-2, 0, 1), matrices.rotate_x(20, degrees=True))
    house = samples.house()
    layers = [
        Layer(house, fill="gold"),
        Layer(samples.cube(), transform=aside, hidden="dash", color="red"),
        Layer(house, scalars=house.positions[:, 1], transform=matrices.rotate_z(-90, degrees=True) @ PLACES),
    ]
    assert np.array_equal(shown, render_array(layers, size=(120, 80)))


@pytest.mark.usefixtures("arrays")
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ["--face-colors", "edges.npy"],
            f"--face-colors: face_colors must have one row for each of the {N_FACES}",
        ),
        (["--vertex-colors", "pairs.npy"], "--vertex-colors: vertex_colors must"),
        (["--edge-colors", "red"], "--edge-colors: expected an .npy file, got 'red'"),
        (["--edge-colors", "-"], "--edge-colors: expected an .npy file, got '-'"),
        (["--edge-colors", "edges.npy", "--color", "red"], "not allowed with"),
        (["--edges", "all,faces.npy"], "--edges: edges must hold integers, got dtype float64"),
        (["--edges", "all,places.npy"], "places.npy: expected an array of shape (m, 2), got (3, 4, 4)"),
        (
            ["--edges", "pairs.npy,most"],
            "--edges: expected all, feature, boundary, silhouette, intersection, an .npy file",
        ),
        (["--fill", "none.npy"], "none.npy: No such file"),
        (["--instances", "pairs.npy"], "pairs.npy: expected an array of shape (k, 4, 4), got (3, 2)"),
        (["house.obj", "--fill", "pairs.npy"], "--fill: house: fill must have"),
        (["--instances", "no_places.npy"], "no_places.npy: expected at least one matrix, got none"),
        (["--edges", "heights.npy"], "heights.npy: expected an array of shape (m, 2), got (10,)"),
        (["--edges", "no_pairs.npy"], "house.obj: edges must choose at least one edge, an array chooses none of"),
        (
            ["--edges", "feature,boundary", "--feature-angle", "180"],
            "edges must choose at least one edge, 'feature' and 'boundary' choose none of 15: no two faces turn",
        ),
        (["--layer", "none.obj"], "none.obj: No such file"),
        (["--layer", "--color red"], "--layer: the following arguments are required: MODEL"),
        (["--layer", "house.obj --color blurple"], "--layer: argument --color: "),
        (
            ["--layer", "house.obj --resolution 5,5"],
            "--layer: expected models with transforms and a style, got",
        ),
        (["--layer", "house.obj --colour red"], "got '--colour'; did you mean --color?"),
        (["--layer", "house.obj --cmap magma"], "--cmap must come with --scalars"),
        (["--layer", "'house.obj"], "--layer: No closing quotation"),
        (["--layer", "house.obj --edges boundary"], "gpu-xform: error: house: edges must choose at least one edge"),
    ],
)
def test_arrays_and_layers_that_cannot_be(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = error_of(["render", "house.obj", "-o", "out.png", *options], capsys)
    assert words in message
    assert not Path("out.png").exists()


def test_a_page_is_true_to_scale(capsys: pytest.CaptureFixture[str]) -> None:
    page = ["--paper", "A4-landscape", "--drawing-scale", "5:1", "--margin", "1cm", "--units", "cm"]
    assert main(["render", "house.obj", "-o", "page.svg", "--camera-direction=-Z", *page]) == 0
    text = Path("page.svg").read_text("utf-8")
    assert 'width="297mm" height="210mm"' in text
    given: dict[str, Any] = {"paper": "A4 landscape", "drawing_scale": 5, "margin": 10, "units": "cm"}
    layer = Layer(samples.house(), name="house")
    assert text == render_svg(layer, camera={"direction": (0, 0, -1)}, **given)
    for options, message in (
        (["--paper", "A6", "--drawing-scale", "99:1"], "--paper: paper must be at least"),
        (["--paper", "A6", "--resolution", "10,10"], "--resolution: size must not be given with paper"),
        (["--drawing-scale", "1:2"], "--drawing-scale must come with --paper"),
        (["--paper", "A6", "--units", "yd"], "expected um, mm, cm"),
    ):
        assert message in error_of(["render", "house.obj", "-o", "out.svg", *options], capsys)
        assert not Path("out.svg").exists()
