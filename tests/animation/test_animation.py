from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform import Animation, Camera, Mesh, PointBuffer, animate, render, render_array, samples, turntable
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from tests.support.reference_transform import AFFINE
from tests.support.types import Array, Pixels

HOUSE = samples.house()
call: Any = partial  # with what is wrong as well
SIZE = (96, 64)
TURNS = np.stack([gx.translate(k, 0, -k) @ gx.rotate((1, 2, 3), 0.4 * k) for k in range(5)])
CAMERA = Camera.look_at((3, 4, 15), (1, 0, 0))


def seen(camera: Camera, points: Array, size: tuple[int, int]) -> Array:
    """Return where points (n, 3) are in the picture, from -1 to 1: (n, 2)."""
    clip = np.column_stack([points, np.ones(len(points))]) @ camera.clip_from_world(size[0] / size[1]).T
    assert (clip[:, 3] > 0).all()
    return np.asarray(clip[:, :2] / clip[:, 3:])


def pixels(animation: Animation, k: int) -> Pixels:
    return np.asarray(animation.frame(k), np.uint8)


def matrix(animation: Animation, k: int) -> Array:
    """Return the matrix of a frame."""
    pose = animation._motion.pose_at(k)
    assert isinstance(pose, np.ndarray)
    return pose


def test_a_frame_is_what_render_draws() -> None:
    animation = animate(HOUSE, TURNS, size=SIZE, camera=CAMERA, color="face", background="navy")
    style: dict[str, Any] = {"size": SIZE, "camera": CAMERA, "color": "face", "background": "navy"}
    for k, turn in enumerate(TURNS):
        frame = animation.frame(k)
        assert (frame.mode, frame.size) == ("RGBA", SIZE)
        assert frame.tobytes() == render(HOUSE, transform=turn, **style).tobytes()
    assert len({frame.tobytes() for frame in animation}) == len(animation) == 5
    assert animation.frame(-2).tobytes() == animation.frame(3).tobytes()


@pytest.mark.parametrize("i", [5, -6, 10**20])
def test_a_frame_that_there_is_not(i: int) -> None:
    with pytest.raises(ArgumentError, match=f"i must be a frame's number below 5, got {i}"):
        animate(HOUSE, TURNS).frame(i)


@pytest.mark.parametrize("i", [1.5, "1", None])
def test_a_frame_s_number_is_whole(i: Any) -> None:
    with pytest.raises(ArgumentTypeError, match="i must be a whole number, got"):
        turntable(HOUSE, 5).frame(i)


def test_an_animation_says_what_it_is() -> None:
    animation = animate(HOUSE, TURNS, size=(30, 20), fps=12.5)
    assert (len(animation), animation.size, animation.fps) == (5, (30, 20), 12.5)
    assert repr(animation) == "<Animation: 5 frames of 30 x 20, 12.5 a second>"


def test_nothing_is_drawn_and_no_function_called_before_it_is_needed() -> None:
    called: list[int] = []

    def turned(k: int) -> Array:
        called.append(k)
        return np.asarray(TURNS[k])

    animation = animate(HOUSE, turned, n_frames=5, camera=CAMERA, size=SIZE)
    assert called == []
    animation.frame(3)
    assert called == [3]
    list(animation)
    assert called == [3, 0, 1, 2, 3, 4]


def test_the_model_is_placed_before_it_moves() -> None:
    placed = animate(HOUSE, TURNS, transform=AFFINE, camera=CAMERA, size=SIZE)
    assert np.array_equal(pixels(placed, 2), render_array(HOUSE, transform=TURNS[2] @ AFFINE, camera=CAMERA, size=SIZE))
    assert not np.array_equal(pixels(placed, 2), pixels(animate(HOUSE, TURNS, camera=CAMERA, size=SIZE), 2))


def test_frames_may_be_models_and_the_model_a_file(tmp_path: Path) -> None:
    bent = [HOUSE.transformed(gx.shear(xy=0.2 * k)) for k in range(3)]
    animation = animate(HOUSE, bent, camera=CAMERA, size=SIZE, transform=AFFINE)
    for k, mesh in enumerate(bent):
        assert np.array_equal(pixels(animation, k), render_array(mesh, transform=AFFINE, camera=CAMERA, size=SIZE))
    gx.save_mesh(HOUSE, tmp_path / "house.obj")
    from_file = animate(tmp_path / "house.obj", TURNS, camera=CAMERA, size=SIZE)
    (tmp_path / "house.obj").unlink()
    assert np.array_equal(pixels(from_file, 1), pixels(animate(HOUSE, TURNS, camera=CAMERA, size=SIZE), 1))


def test_several_models_move_together_each_in_its_own_style(tmp_path: Path) -> None:
    gx.save_mesh(samples.cube(), tmp_path / "cube.obj")
    fixed = gx.translate(0, 2, 0)
    layers: list[gx.Layer | Path] = [gx.Layer(HOUSE, color="red", transform=AFFINE), tmp_path / "cube.obj"]
    animation = animate(layers, TURNS, size=SIZE, camera=CAMERA, transform=fixed, line_width=3)
    (tmp_path / "cube.obj").unlink()
    moved = [
        gx.Layer(HOUSE, color="red", transform=TURNS[3] @ AFFINE),
        gx.Layer(samples.cube(), transform=TURNS[3] @ fixed, line_width=3),
    ]
    assert np.array_equal(pixels(animation, 3), render_array(moved, camera=CAMERA, size=SIZE))
    in_a_row = animate(HOUSE, TURNS, size=SIZE, camera=CAMERA, transform=[fixed, AFFINE])
    expected = render_array(HOUSE, transform=[TURNS[1] @ fixed, TURNS[1] @ AFFINE], camera=CAMERA, size=SIZE)
    assert np.array_equal(pixels(in_a_row, 1), expected)


def test_points_on_the_device_move_as_well() -> None:
    with PointBuffer(HOUSE.positions) as buffer:
        animation = animate(buffer, TURNS, size=SIZE, camera=CAMERA, edges=HOUSE.edges)
        expected = render_array(buffer, transform=TURNS[4], size=SIZE, camera=CAMERA, edges=HOUSE.edges)
        assert np.array_equal(pixels(animation, 4), expected)
        assert len(np.unique(expected)) > 2


@pytest.mark.parametrize("size", [(320, 90), (90, 320)])
@pytest.mark.parametrize("fit", [None, {"direction": (0, 0, -1), "margin": 0.2}, {"orthographic": True}], ids=str)
def test_one_camera_holds_the_model_in_every_frame(size: tuple[int, int], fit: dict[str, Any] | None) -> None:
    animation = animate(HOUSE, lambda k: TURNS[k], n_frames=5, size=size, camera=fit)
    everywhere = [HOUSE.transformed(matrix).positions for matrix in TURNS]
    expected = Camera.fit(np.concatenate(everywhere), **(fit or {})).clip_from_world(size[0] / size[1])
    np.testing.assert_allclose(animation.camera.clip_from_world(size[0] / size[1]), expected, atol=1e-12)
    filled = 1 - 2 * (fit or {}).get("margin", 0.05)
    reached = [np.abs(seen(animation.camera, points, size)).max() for points in everywhere]
    assert max(reached) == pytest.approx(filled, abs=1e-9)
    assert min(reached) < filled - 0.01


def test_what_lies_behind_a_projection_s_eye_in_some_frames_is_not_framed() -> None:
    frames = [gx.perspective_from_eye(5) @ gx.translate(0, 0, 4 * k) for k in range(3)]
    camera = animate(HOUSE, frames, size=(50, 50)).camera
    with np.errstate(divide="ignore"):
        homogeneous = np.concatenate([np.column_stack([HOUSE.positions, np.ones(10)]) @ m.T for m in frames])
    before = homogeneous[homogeneous[:, 3] > 0]
    assert len(before) < len(homogeneous)
    expected = Camera.fit(before[:, :3] / before[:, 3:]).clip_from_world(1)
    np.testing.assert_allclose(camera.clip_from_world(1), expected, rtol=1e-9, atol=1e-9)
    with pytest.raises(MeshError, match="without points cannot be framed"):
        animate(HOUSE, [gx.perspective_from_eye(5) @ gx.translate(0, 0, 9)]).frame(0)


@pytest.mark.parametrize("fit", [None, {"orthographic": True}], ids=str)
@pytest.mark.parametrize(
    ("matrix", "transform", "message"),
    [
        (gx.translate(1e308, 0, 0), None, r"the model must have coordinates of at most 1e\+300, got 1e\+308"),
        (gx.scale(-1e308), None, r"the model must have coordinates of at most 1e\+300, got -?(inf|1e\+308)"),
        (gx.scale(1e200), gx.scale(1e200), "the frame's matrix times transform must stay within float64's range"),
    ],
)
def test_a_frame_that_is_out_of_range_is_named(
    matrix: Array, transform: Array | None, message: str, fit: dict[str, Any] | None
) -> None:
    animation = animate(HOUSE, [np.eye(4), np.eye(4), matrix], size=SIZE, camera=fit, transform=transform)
    with pytest.raises(ArgumentError, match=f"^frame 2: {message}"):
        animation.frame(0)


@pytest.mark.parametrize(
    ("axis", "turned"),
    [("x", (0, 0, 1)), ("y", (1, 0, 0)), ("z", (0, 1, 0)), ((0, -2, 0), (-1, 0, 0)), (np.array([0, 0, 1]), (0, 1, 0))],
)
def test_a_turntable_rotates_once_about_the_centre(axis: Any, turned: tuple[float, float, float]) -> None:
    """A quarter turn takes the next axis but one to where the right-hand rule has it."""
    model = HOUSE.transformed(gx.chain(gx.scale(1, 2, 3), gx.translate(10, 20, 30)))
    animation = turntable(model, 4, axis=axis, size=SIZE)
    middle = np.append(model.center, 1)
    start = {"x": (0, 1, 0), "y": (0, 0, 1), "z": (1, 0, 0)}.get(axis if isinstance(axis, str) else "")
    start = start or ((0, 0, 1) if np.ravel(axis)[1] else (1, 0, 0))
    quarter = matrix(animation, 1)
    assert np.allclose(quarter @ middle, middle)
    assert np.allclose((quarter @ np.append(start, 0))[:3], turned)
    matrices = np.stack([matrix(animation, k) for k in range(4)])
    assert np.allclose(matrices, [np.linalg.matrix_power(quarter, k) for k in range(4)])
    assert np.array_equal(matrices[0], np.eye(4))
    assert np.allclose(quarter @ matrices[3], np.eye(4))


@pytest.mark.parametrize(
    "camera",
    [{"up": (0, 0, 1)}, {"up": (0, 0, 2), "direction": (1, 0, 0)}, Camera.look_at((9, 0, 0), (0, 0, 0), (0, 0, 1))],
)
def test_a_turntable_turns_about_what_is_up(camera: Any) -> None:
    own, about_z = (turntable(HOUSE, 4, camera=camera, size=(16, 16), **axis) for axis in ({}, {"axis": "z"}))
    assert np.allclose(matrix(own, 1), matrix(about_z, 1))
    assert pixels(own, 0).tobytes() == pixels(about_z, 0).tobytes()


def test_a_turntable_starts_at_the_front() -> None:
    # A cube shows alike sides left and right in each of eight frames; points that no face uses change nothing.
    cube = samples.cube().transformed(gx.translate(20, 15, 8))
    stray = Mesh(np.vstack([cube.positions, [[0, 0, 0]]]), cube.faces)
    for up in ((0, 1, 0), (0, 0, 1)):
        for frame in turntable(stray, 8, size=(100, 75), axis=up, camera={"up": up}):
            _, xs = np.nonzero(np.asarray(frame.convert("L")) < 200)
            assert abs((xs.min() + xs.max()) / 2 - 49.5) <= 1.0
    aimed = turntable(cube, 8, size=(100, 75), camera={"direction": (-1, -1, -1)})
    assert pixels(aimed, 0).tobytes() != pixels(turntable(cube, 8, size=(100, 75)), 0).tobytes()


def test_a_turntable_rotates_what_was_transformed() -> None:
    placed = gx.chain(gx.rotate_x(1), gx.translate(5, 0, 0))
    animation = turntable(HOUSE, 8, transform=placed, size=SIZE)
    moved = HOUSE.transformed(placed)
    for k in range(8):
        corners = np.column_stack([moved.positions, np.ones(10)]) @ matrix(animation, k).T
        assert np.allclose(corners.mean(axis=0)[1], moved.positions.mean(axis=0)[1])
    expected = pixels(turntable(moved, 8, size=SIZE), 3)
    difference = np.abs(pixels(animation, 3).astype(int) - expected)
    assert difference.max() <= 2


def test_a_turntable_takes_what_animate_takes(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    path = tmp_path / "turn.gif"
    options: dict[str, Any] = {"size": SIZE, "fps": 10, "camera": {"orthographic": True}, "color": "face"}
    animation = turntable(HOUSE, 3, path, progress=lambda *step: told.append(step), **options)
    assert (len(animation), animation.fps, told) == (3, 10, [(1, 3), (2, 3), (3, 3)])
    with Image.open(path) as image:
        assert getattr(image, "n_frames", 1) == 3


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (call(turntable, HOUSE, 0), "frames must be at least 1, got 0"),
        (call(turntable, HOUSE, 2.5), "frames must be a whole number, got 2.5"),
        (call(turntable, HOUSE, axis="w"), r"axis must be three numbers, or an axis such as '\+Y' or '-z', got 'w'"),
        (call(turntable, HOUSE, axis=(0, 0, 0)), "axis must not be the zero vector"),
        (call(turntable, HOUSE, transform=np.eye(4)[:3]), "transform must have shape"),
        (call(turntable, Mesh([], [])), "a model without points"),
        (call(animate, HOUSE, TURNS, size=(10, 0)), "size must be two positive whole numbers"),
        (call(animate, HOUSE, TURNS, camera="front"), "camera must be a Camera or a dict of Camera.fit's, got str"),
        (call(animate, HOUSE, TURNS, camera={"zoom": 2}), "camera must have keys among direction, .*, got 'zoom'$"),
        (call(animate, HOUSE, TURNS, camera={"margin": 0.5}), r"margin must lie in \[-50, 0.5\)"),
        (
            call(animate, 5, TURNS),
            "model must be a Mesh, an array of points, a PointBuffer, a path, a Layer or a Scene, got int",
        ),
        (call(animate, np.zeros((5, 2)), TURNS), r"model must have shape \(n, 3\), got \(5, 2\)"),
        (call(animate, HOUSE, TURNS, transform=np.eye(3)), "transform must have shape"),
        (call(animate, HOUSE, TURNS, "out.avi"), r"path must end in one of .*\.gif, .*\.mp4.*, got 'out.avi'"),
        (call(animate, HOUSE, TURNS, "out"), r"path must end in one of .*, got 'out'"),
        (call(animate, HOUSE, TURNS, 5), "path must be a path, got int"),
    ],
)
def test_what_cannot_be_is_said_at_once(made: Any, message: str) -> None:
    with pytest.raises((ArgumentError, ArgumentTypeError, MeshError), match=message):
        made()


def test_a_keyword_that_render_does_not_know() -> None:
    with pytest.raises(TypeError, match="colour"):
        call(animate, HOUSE, TURNS, colour="red")()


def test_a_frame_s_model_takes_the_place_of_the_first_and_the_others_stay() -> None:
    bent = [HOUSE.transformed(gx.shear(xy=0.2 * k)) for k in range(3)]
    cube = gx.Layer(samples.cube(), color="blue")
    first = gx.Layer(HOUSE, color="red", transform=AFFINE)
    animation = animate([first, cube, HOUSE], bent, camera=CAMERA, size=SIZE, line_width=3)
    expected = [gx.Layer(bent[2], color="red", transform=AFFINE), cube, gx.Layer(HOUSE, line_width=3)]
    assert np.array_equal(pixels(animation, 2), render_array(expected, camera=CAMERA, size=SIZE))
    alone = animate(first, bent, camera=CAMERA, size=SIZE)
    assert np.array_equal(
        pixels(alone, 1), render_array(gx.Layer(bent[1], color="red", transform=AFFINE), camera=CAMERA, size=SIZE)
    )
    own = animate([first, cube], [gx.Layer(bent[1], color="green")], camera=CAMERA, size=SIZE)
    assert np.array_equal(
        pixels(own, 0), render_array([gx.Layer(bent[1], color="green"), cube], camera=CAMERA, size=SIZE)
    )


def test_a_scene_is_not_replaced_by_a_model_without_a_word() -> None:
    scene = gx.Scene()
    scene.add(HOUSE, name="house")
    animation = animate(scene, [HOUSE], camera=CAMERA, size=SIZE)
    with pytest.raises(
        gx.ArgumentTypeError, match=r"frames must be scenes, .* if the first model is a Scene, got Mesh"
    ):
        animation.frame(0)


def test_frames_are_had_by_their_indices() -> None:
    animation = animate(HOUSE, TURNS, size=SIZE)
    assert np.array_equal(np.asarray(animation[3]), pixels(animation, 3))
    assert np.array_equal(np.asarray(animation[-1]), pixels(animation, len(TURNS) - 1))
    part = animation[1:4]
    assert len(part) == 3
    assert part.camera is animation.camera
    assert np.array_equal(pixels(part, 2), pixels(animation, 3))
    assert np.array_equal(np.asarray(animation[::-1][0]), np.asarray(animation[-1]))
    with pytest.raises(IndexError, match=rf"^frame {len(TURNS)} of {len(TURNS)}$"):
        animation[len(TURNS)]
    with pytest.raises(gx.ArgumentError, match=r"^frames must choose some of \d+ frames, got slice"):
        animation[3:3]


def test_a_simulation_shows_itself_in_a_notebook() -> None:
    cloth = gx.Springs(samples.cloth(4, 4), mass=0.1, stretch=50.0, pinned=[0, 4])
    path = cloth.simulate(0.2, 20.0, keep="device")
    shown = animate([cloth, gx.Layer(HOUSE, color="red")], path, size=SIZE, hidden="remove")
    page = shown._repr_html_()
    assert page.startswith("<iframe")
    assert "data:image" in page or "base64" in page
    assert shown.fps == pytest.approx(20.0)
    assert len(shown) == len(path) == 5
