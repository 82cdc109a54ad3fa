"""Section cuts in pictures: what is removed, capped, outlined and hatched, and what is refused."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.cli.argument_types.styles import parse_section
from gpu_xform.drawing.layer import SHADED_FILL
from gpu_xform.drawing.sections import cut_sections
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.imaging.colors import to_rgba

SIZE = (128, 128)
CAMERA = Camera.look_at((0, 0, 8), (0, 0, 0), fov_y=18.0, orthographic=True)
PLANE = ((0, 0, 0), (0, 0, 1))
BALL = samples.icosphere(3)
SHELL = Mesh(
    np.concatenate([BALL.positions, 0.6 * BALL.positions]),
    [*BALL.faces, *(np.add(face, BALL.n_points)[::-1] for face in BALL.faces)],
)
YELLOW, BLUE = (255, 215, 0), (0, 0, 255)


def color_at(picture: Any, x: float, y: float) -> tuple[int, ...]:
    """Return the colour of the picture at a point of the plane, in units of the world."""
    half = 8.0 * np.tan(np.radians(9.0))
    column, row = ((x / half + 1.0) / 2.0 * SIZE[0], (1.0 - y / half) / 2.0 * SIZE[1])
    return tuple(picture[int(row), int(column), :3].tolist())


def picture(*layers: Layer) -> Any:
    return gx.render_array(list(layers), camera=CAMERA, size=SIZE)


def test_a_cap_hides_what_is_behind_it_and_a_hole_does_not() -> None:
    back = Layer(
        samples.cube(),
        transform=matrices.chain(matrices.scale(2, 2, 0.1), matrices.translate(0, 0, -2)),
        fill="blue",
        edges=[],
    )
    solid = picture(back, Layer(BALL, fill="gold", edges="silhouette", section=PLANE))
    assert color_at(solid, 0.3, 0.2) == YELLOW
    assert color_at(solid, 1.15, 0.1) == BLUE
    shell = picture(back, Layer(SHELL, fill="gold", edges="silhouette", section=PLANE))
    assert color_at(shell, 0.8, 0.1) == YELLOW
    inside = Layer(samples.cube(), transform=matrices.scale(0.1), fill="blue", edges=[])
    seen = picture(Layer(SHELL, fill="gold", edges="silhouette", section=PLANE), inside)
    assert color_at(seen, 0.0, 0.0) == BLUE  # through the hole, of which the cap leaves the middle open


def test_the_outline_is_twice_as_wide_and_hatching_half() -> None:
    layers = cut_sections([Layer(SHELL, name="shell", edges="silhouette", line_width=2.0, section=PLANE, hatch=True)])
    assert [layer.name for layer in layers] == ["shell", "shell cut area", "shell hatching", "shell section"]
    assert [layer.line_width for layer in layers] == [2.0, 2.0, 1.0, 4.0]
    lines: Any = layers[2].model
    ends = lines.positions.reshape(-1, 2, 3)
    along = (ends[:, 1] - ends[:, 0]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[:, None]
    np.testing.assert_allclose(np.abs(along @ np.array([1, 1, 0]) / np.sqrt(2)), 1.0, atol=1e-9)
    radii = np.linalg.norm(ends.mean(axis=1), axis=1)
    assert radii.min() > 0.0
    assert (np.linalg.norm(ends, axis=2) > 0.58).all()  # none in the hole


def test_hatching_lies_as_far_apart_as_it_is_told() -> None:
    n_lines = []
    for spacing in (0.2, 0.1):
        layers = cut_sections([Layer(BALL, name="ball", section=PLANE, hatch=(45, spacing))])
        [model] = [layer.model for layer in layers if layer.name == "ball hatching"]
        assert isinstance(model, Mesh)
        n_lines.append(model.n_faces)
    assert n_lines[1] - 2 * n_lines[0] in (-1, 0, 1)


def test_bodies_in_one_another_are_areas_of_their_own_and_hatched_in_turn() -> None:
    within = BALL.transformed(matrices.scale(0.5))
    outer = Layer(BALL, name="outer", fill="gold", section=PLANE, hatch=True)
    inner = Layer(within, name="inner", fill="blue", section=PLANE, hatch=True)
    layers = {layer.name: layer for layer in cut_sections([outer, inner])}
    turns = []
    for name in ("outer", "inner"):
        model: Any = layers[f"{name} hatching"].model
        turns.append(np.prod((model.positions[1] - model.positions[0])[:2]) > 0)
    assert turns == [True, False]
    drawn = picture(
        *(
            Layer(each, fill=color, edges="silhouette", section=PLANE)
            for each, color in ((BALL, "gold"), (within, "blue"))
        )
    )
    assert color_at(drawn, 0.1, 0.1) == BLUE
    assert color_at(drawn, 0.75, 0.1) == YELLOW
    both = Mesh(
        np.concatenate([BALL.positions, within.positions]),
        [*BALL.faces, *(np.add(face, BALL.n_points) for face in BALL.faces)],
    )
    one = {layer.name: layer for layer in cut_sections([Layer(both, name="both", section=PLANE, hatch=True)])}
    cap: Any = one["both cut area"].model
    area = sum(
        np.linalg.norm(np.cross(*(cap.positions[list(face)][1:] - cap.positions[face[0]]))) / 2 for face in cap.faces
    )
    assert area == pytest.approx(np.pi, rel=0.02)


def test_bodies_of_one_mesh_are_hatched_in_turn_and_capped_in_their_own_colours() -> None:
    moves = [(0, 0, 0), (2, 0, 0), (4, 0, 0), (4, 0, 0)]  # side by side, the last one within the third
    scales = [1.0, 1.0, 1.0, 0.5]
    cubes = [samples.cube().transformed(matrices.chain(matrices.scale(size), matrices.translate(*move)))
             for size, move in zip(scales, moves, strict=True)]  # fmt: skip
    faces = [np.array(cube.faces) + 8 * k for k, cube in enumerate(cubes)]
    mesh = Mesh(np.concatenate([cube.positions for cube in cubes]), np.concatenate(faces))
    colors = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0)]).repeat(6, axis=0).astype(float)
    colors[0] = (0, 1, 1)  # one face that is painted
    colors[6:9] = (1, 0, 1)  # half of them
    layers = {layer.name: layer for layer in cut_sections(
        [Layer(mesh, name="four", fill=colors, section=((0, 0, 0.1), (0, 0, 1)), hatch=True)])}  # fmt: skip
    lines: Any = layers["four hatching"].model
    ends = lines.positions.reshape(-1, 2, 3)
    turns = (ends[:, 1] - ends[:, 0])[:, :2].prod(axis=1) > 0
    middles = ends.mean(axis=1)
    is_inner = np.abs(middles[:, :2] - (4, 0)).max(axis=1) < 0.5
    for k, expected in enumerate((True, False, True)):
        chosen = (np.abs(middles[:, 0] - 2 * k) < 1.0) & ~is_inner
        assert chosen.any()
        assert (turns[chosen] == expected).all()
    assert is_inner.any()
    assert not turns[is_inner].any()
    cap: Any = layers["four cut area"]
    places = np.array([cap.model.positions[list(face)].mean(axis=0) for face in cap.model.faces])
    grey = tuple(to_rgba(SHADED_FILL, "fill")[:3])
    for x, color in ((0, (1, 0, 0)), (2, grey), (4, (1, 1, 0))):
        own = np.abs(places[:, :2] - (x, 0)).max(axis=1) < 0.5
        assert own.any()
        np.testing.assert_allclose(np.asarray(cap.fill)[own, :3], np.tile(color, (own.sum(), 1)))


@pytest.mark.parametrize("in_layers", [False, True])
@pytest.mark.parametrize("pin_first", [False, True])
def test_a_pin_that_fills_its_bore_is_an_area_of_its_own(pin_first: bool, in_layers: bool) -> None:
    parts = [BALL.transformed(matrices.scale(0.6)), SHELL][:: 1 if pin_first else -1]
    style: dict[str, Any] = {"section": PLANE, "hatch": True, "name": "part"}
    if in_layers:
        layers = cut_sections([Layer(part, **style) for part in parts])
    else:
        faces = [*parts[0].faces, *(np.add(face, parts[0].n_points) for face in parts[1].faces)]
        layers = cut_sections([Layer(Mesh(np.concatenate([part.positions for part in parts]), faces), **style)])
    ends: Any = np.concatenate([layer.model.positions for layer in layers if layer.name == "part hatching"])  # type: ignore[union-attr]
    ends = ends.reshape(-1, 2, 3)
    turns = (ends[:, 1] - ends[:, 0])[:, :2].prod(axis=1) > 0
    is_pin = np.linalg.norm(ends, axis=2).max(axis=1) < 0.601
    assert len(set(turns[is_pin])) == len(set(turns[~is_pin])) == 1
    assert turns[is_pin][0] != turns[~is_pin][0]
    assert (np.linalg.norm(ends[~is_pin], axis=2) > 0.58).all()


def test_styles_by_face_and_point_follow_the_cut() -> None:
    cube = samples.cube()
    [cut, *_] = cut_sections(
        [Layer(cube, section=((0, 0, 0.25), (0, 0, 1)), fill=np.eye(6, 3), scalars=cube.positions[:, 2])]
    )
    model: Any = cut.model
    np.testing.assert_allclose(np.asarray(cut.scalars), model.positions[:, 2], atol=1e-12)
    assert len(cut.fill) == model.n_faces == 5
    instances = cut_sections([Layer(cube, transform=np.stack([np.eye(4), matrices.translate(0, 0, 9)]), section=PLANE)])
    assert sum(layer.name is None for layer in instances) == 1  # the other lies before the plane


def test_it_works_in_svg_and_with_intersections_and_cut_files(tmp_path: Any) -> None:
    gx.save_mesh(SHELL, tmp_path / "shell.off")
    text = gx.render_svg(tmp_path / "shell.off", edges=["silhouette"], section=PLANE, hatch=(30, 0.1), size=SIZE)
    for title in ("shell", "shell hatching", "shell section"):
        assert f"<title>{title}</title>" in text


@pytest.mark.parametrize(
    ("style", "error", "message"),
    [
        (
            {"section": ((0, 0, 2), (0, 0, 2))},
            ArgumentError,
            "^section must cut the models, which lie -3 to -1 along its",
        ),
        (
            {"section": ((0, 0, -2), (0, 0, 1))},
            ArgumentError,
            "^section must cut the models, which lie 1 to 3 along its",
        ),
        ({"section": 5}, ArgumentTypeError, r"^section must be \(point, normal\), such as .*'\+X'\), got 5$"),
        ({"section": ((0, 0), (0, 0, 1))}, ArgumentError, r"^section\[0\] must"),
        ({"section": ((0, 0, 0), (0, 0, 0))}, ArgumentError, r"^section\[1\] must"),
        ({"hatch": True}, ArgumentError, "^hatch must go with section$"),
        (
            {"section": PLANE, "hatch": "lines"},
            ArgumentTypeError,
            "^hatch must be True or 'auto', an angle in degrees",
        ),
        ({"section": PLANE, "hatch": (45, 0)}, ArgumentError, "^hatch must have a positive spacing, got 0$"),
        (
            {"section": PLANE, "edges": [(0, 1)]},
            ArgumentError,
            "^edges must be names of sets with section, got an array$",
        ),
        (
            {"section": PLANE, "edge_colors": np.zeros((12, 3))},
            ArgumentError,
            "^edge_colors must not be given with section$",
        ),
    ],
    ids=str,
)
def test_what_cuts_nothing_is_refused(style: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        gx.render_array(samples.cube(), size=SIZE, **style)


def test_caps_and_hatching_have_no_colour_bar_and_no_place_in_a_legend() -> None:
    layer = Layer(BALL, scalars="x", colorbar=True, section=PLANE, hatch=True)
    assert gx.render_array(layer, size=(200, 128)).shape == (128, 200, 4)
    assert gx.render_array(Layer(BALL, section=PLANE, hatch=True), size=(200, 128), legend=["ball"]).shape[1] == 200


def test_the_library_takes_the_forms_of_the_command_and_the_command_axes() -> None:
    typed = gx.Layer(samples.cube(), section=((0, 0.1, 0), "-y"), hatch="auto", dash="4,2")
    written = gx.Layer(samples.cube(), section=((0, 0.1, 0), (0, -1, 0)), hatch=True, dash=(4, 2))
    assert (typed.hatch, typed.dash) == (written.hatch, written.dash)
    np.testing.assert_array_equal(np.array(typed.section), np.array(written.section))
    for text in ("0,0.1,0,-Y", "0,0.1,0,0,-1,0"):
        assert parse_section(text) == ([0.0, 0.1, 0.0], [0.0, -1.0, 0.0])
