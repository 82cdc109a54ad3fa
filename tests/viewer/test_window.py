import dataclasses
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Unpack

import glfw
import numpy as np
import pytest
from PIL import Image
from rendercanvas.offscreen import OffscreenRenderCanvas

from gpu_xform import Camera, Layer, Mesh, Scene, render_array, samples, save_mesh, translate, view
from gpu_xform.annotation.options import NO_OPTIONS, AnnotationOptions
from gpu_xform.cli import main
from gpu_xform.drawing.camera import CameraLike
from gpu_xform.drawing.layer import Models, Style
from gpu_xform.errors import ArgumentError, ArgumentTypeError, DeviceError, DisplayError, MeshError, MissingExtraError
from gpu_xform.imaging.colors import ColorLike
from gpu_xform.viewer import session as session_module
from gpu_xform.viewer import window as window_module
from gpu_xform.viewer.canvas import connect
from gpu_xform.viewer.orbit import BoundingSphere, Orbit
from gpu_xform.viewer.session import Session
from tests.support.full_disk import largest_file
from tests.support.types import Array, Pixels
from tests.support.xvfb import Screen, require_windows

HOUSE = samples.house()
SIZE = (120, 80)
START = Orbit.from_camera(Camera.fit(HOUSE), 1.5, BoundingSphere.around(HOUSE.positions))


class Window:
    """A window that nobody sees."""

    def __init__(
        self,
        models: Models = HOUSE,
        *,
        camera: CameraLike | None = None,
        up: Array | None = None,
        background: ColorLike | None = "white",
        pixel_ratio: float = 1.0,
        annotations: AnnotationOptions = NO_OPTIONS,
        **style: Unpack[Style],
    ) -> None:
        self.session = Session(models, camera, up, SIZE, background, None, "auto", style, annotations=annotations)
        self.canvas = OffscreenRenderCanvas(size=SIZE, pixel_ratio=pixel_ratio)
        self.titles: list[str] = []
        self.canvas._rc_set_title = self.titles.append
        self.failures = connect(self.canvas, self.session)

    def do(self, kind: str, **event: Any) -> None:
        self.canvas.submit_event({"event_type": kind, "modifiers": (), **event})
        self.canvas._process_events()

    def key(self, *names: str) -> None:
        for name in names:
            self.do("key_down", key=name)

    def drag(self, start: tuple[float, float], end: tuple[float, float], button: int = 1) -> None:
        held = {"button": button, "buttons": (button,)}
        self.do("pointer_down", x=start[0], y=start[1], **held)
        self.do("pointer_move", x=end[0], y=end[1], **held)
        self.do("pointer_up", x=end[0], y=end[1], button=button, buttons=())

    def shown(self) -> Pixels:
        return np.asarray(self.canvas.draw())


pytestmark = pytest.mark.usefixtures("working_folder")


def expected(models: Models = HOUSE, size: tuple[int, int] = SIZE, **arguments: Any) -> Pixels:
    return render_array(models, size=size, **arguments)


def scene() -> Scene:
    made = Scene()
    made.add(samples.cube(), name="a", color="red")
    made.add(HOUSE, name="b", parent="a", transform=translate(2, 0, 0))
    return made


@pytest.mark.parametrize(
    ("models", "style"),
    [
        (HOUSE, {}),
        (HOUSE, {"color": "face", "line_width": 3.0, "transform": translate(1, 2, 3)}),
        (HOUSE, {"camera": Camera.window((-3, 3), (-3, 3)), "background": "navy"}),
        (HOUSE, {"camera": {"direction": (0, 0, -1), "margin": 0.2}, "transform": translate(1, 2, 3)}),
        ([HOUSE, Layer(samples.cube(), fill="gold")], {"hidden": "dash"}),
        (scene(), {}),
        (Mesh(HOUSE.positions, []), {}),
    ],
)
def test_a_window_first_shows_what_render_draws(models: Models, style: dict[str, Any]) -> None:
    np.testing.assert_array_equal(Window(models, **style).shown(), expected(models, **style))


def test_an_up_says_how_the_first_view_stands_and_what_drags_turn_about() -> None:
    window = Window(up=np.array([0.0, 0.0, 1.0]))
    upright = Camera.fit(HOUSE, direction=(-0.45, 1.0, -0.4), up=(0, 0, 1))
    np.testing.assert_array_equal(window.shown(), expected(camera=upright))
    window.drag((40, 40), (80, 40))
    orbit = Orbit.from_camera(upright, 1.5, BoundingSphere.around(HOUSE.positions)).rotated(np.pi / 2, 0.0)
    np.testing.assert_array_equal(orbit.up, (0, 0, 1))
    np.testing.assert_array_equal(window.shown(), expected(camera=orbit.camera))


@pytest.mark.parametrize(("own", "up"), [({}, (0, 0, 1)), ({"up": (1, 0, 0)}, (1, 0, 0))])
def test_an_up_is_that_of_a_dict_that_has_none(own: dict[str, Any], up: tuple[int, int, int]) -> None:
    window = Window(camera={"direction": (0, -1, 0), **own}, up=np.array([0.0, 0.0, 1.0]))
    seen = Camera.fit(HOUSE, direction=(0, -1, 0), up=up)
    np.testing.assert_array_equal(window.shown(), expected(camera=seen))
    window.do("wheel", x=60, y=40, dx=0, dy=-300)
    assert not np.array_equal(window.shown(), expected(camera=seen))
    window.key("r")
    np.testing.assert_array_equal(window.shown(), expected(camera=seen))


def test_a_file_is_read_once(tmp_path: Path) -> None:
    path = tmp_path / "house of cards.obj"
    save_mesh(HOUSE, path)
    window = Window(str(path))
    path.unlink()
    np.testing.assert_array_equal(window.shown(), expected())
    assert window.titles[-1] == "house of cards - H shows the keys"


def test_drags_and_wheels_show_what_their_cameras_see() -> None:
    window = Window()
    window.drag((60, 40), (80, 44))
    orbit = START.rotated(np.pi * 20 / 80, np.pi * 4 / 80)
    np.testing.assert_array_equal(window.shown(), expected(camera=orbit.camera))
    window.drag((30, 20), (60, 40), button=2)
    orbit = orbit.panned(np.array([-0.5, 0.5]), np.zeros(2), 1.5)
    np.testing.assert_array_equal(window.shown(), expected(camera=orbit.camera))
    window.do("wheel", x=30, y=20, dx=0, dy=-200)
    orbit = orbit.zoomed(1.2**-2, np.array([-0.5, 0.5]), 1.5)
    moved = expected(camera=orbit.camera)
    np.testing.assert_array_equal(window.shown(), moved)
    assert (moved != expected()).any()
    window.key("r")
    np.testing.assert_array_equal(window.shown(), expected())


def test_keys_show_what_their_styles_are() -> None:
    cube = samples.cube()
    [corners, *others] = [list(face) for face in cube.faces]
    creased = Mesh(cube.positions, [corners[:3], [corners[0], *corners[2:]], *others])  # its diagonal is no crease
    window = Window(creased)
    style: dict[str, Any] = {}
    changes: list[tuple[str, dict[str, Any] | None]] = [
        ("e", {"edges": "feature"}),
        ("d", {"hidden": "remove"}),
        ("f", {"fill": "lightgray"}),
        ("c", {"fill": "face"}),
        ("a", {"antialias": False}),
        ("b", {"background": "#1e1e1e"}),
        ("Backspace", None),
    ]
    for name, change in changes:
        style = {} if change is None else style | change
        before = window.shown()
        window.key(name)
        now = window.shown()
        np.testing.assert_array_equal(now, expected(creased, **style), err_msg=name)
        assert (now != before).any(), name


def test_keys_change_every_model_but_leave_what_they_do_not_name() -> None:
    models: list[Mesh | Layer] = [HOUSE, Layer(samples.cube(), color="red", line_width=4.0)]
    window = Window(models)
    window.key("d")
    layers = [Layer(HOUSE, hidden="remove"), Layer(samples.cube(), color="red", line_width=4.0, hidden="remove")]
    np.testing.assert_array_equal(window.shown(), expected(layers))
    assert window.titles[-1] == "gpu-xform and 1 more - hidden edges: remove"


def test_a_finer_screen_shows_the_same_in_more_pixels() -> None:
    window = Window(pixel_ratio=2.0, line_width=1.5)
    np.testing.assert_array_equal(window.shown(), expected(size=(240, 160), line_width=3.0))
    window.drag((60, 40), (80, 44))
    orbit = START.rotated(np.pi * 20 / 80, np.pi * 4 / 80)
    np.testing.assert_array_equal(window.shown(), expected(size=(240, 160), line_width=3.0, camera=orbit.camera))


def test_texts_are_as_large_on_a_finer_screen() -> None:
    options: dict[str, Any] = {"axes": True, "legend": ["house"]}
    annotations = AnnotationOptions(**options, font_size=7.0)
    style: dict[str, Any] = {"labels": "names", "name": "house"}
    for ratio in (1, 2):
        shown = Window(pixel_ratio=float(ratio), annotations=annotations, line_width=1.5, **style).shown()
        size = SIZE[0] * ratio, SIZE[1] * ratio
        picture = expected(size=size, line_width=1.5 * ratio, font_size=7.0 * ratio, **options, **style)
        np.testing.assert_array_equal(shown, picture)


def test_a_window_of_another_shape_shows_all_of_the_model() -> None:
    window = Window()
    window.canvas.set_logical_size(50, 90)
    np.testing.assert_array_equal(window.shown(), expected(size=(50, 90)))


def test_what_is_transparent_is_shown_on_white() -> None:
    shown = Window(background=None).shown()
    assert (shown[..., 3] == 255).all()
    assert np.abs(shown.astype(int) - expected()).max() <= 1


def test_the_keys_are_shown_over_the_picture() -> None:
    window = Window()
    window.canvas.set_logical_size(700, 600)
    plain = window.shown()
    window.key("h")
    helped = window.shown()
    changed = (helped != plain).any(axis=2)
    assert changed[:300, :300].mean() > 0.9
    assert not changed[:, 650:].any()
    window.key("h")
    np.testing.assert_array_equal(window.shown(), plain)
    window.canvas.set_logical_size(400, 100)
    plain = window.shown()
    window.key("h")
    changed = (window.shown() != plain).any(axis=2)
    assert changed[:, :100].mean() > 0.9
    assert not changed[:, 200:].any()  # all of the panel is there, and small


def test_s_saves_what_is_seen_beside_what_is_there(tmp_path: Path) -> None:
    window = Window(name="a/b", background=None)
    window.key("f", "h")
    window.shown()
    window.key("s", "s")
    drawn = expected(fill="lightgray", background=None)
    for name in ("a_b-1.png", "a_b-2.png"):
        with Image.open(tmp_path / name) as saved:
            np.testing.assert_array_equal(np.asarray(saved), drawn)
    assert window.titles[-1] == "a/b - saved a_b-2.png"
    window.key("e")
    assert window.titles[-1] == "a/b - edges: feature"


def test_what_cannot_be_saved_is_said_and_the_window_stays(tmp_path: Path) -> None:
    window = Window(name="n" * 300)
    window.shown()
    window.key("s")
    assert window.titles[-1].endswith("- not saved: File name too long")
    assert list(tmp_path.iterdir()) == []
    assert not window.canvas.get_closed()


def test_a_picture_that_does_not_fit_the_disk_leaves_no_half(tmp_path: Path) -> None:
    window = Window()
    window.shown()
    with largest_file(500):
        window.key("s")
    assert window.titles[-1].endswith("- not saved: File too large")
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_drawn_shows_the_background_and_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise MeshError("points must be finite")

    window = Window(background="navy")
    with monkeypatch.context() as patch:
        patch.setattr("gpu_xform.viewer.session.render_array", fail)
        assert (window.shown() == (0, 0, 128, 255)).all()
        assert window.titles[-1] == "gpu-xform - points must be finite"
    window.key("e")
    np.testing.assert_array_equal(window.shown(), expected(edges="feature", background="navy"))
    assert window.titles[-1] == "gpu-xform - edges: feature"


def test_e_passes_over_sets_that_have_no_edges_and_shows_outlines_in_place_of_none() -> None:
    ball = samples.icosphere(3)
    window = Window(ball)
    for edges in ("silhouette", "all", "silhouette"):
        window.key("e")
        np.testing.assert_array_equal(window.shown(), expected(ball, edges=edges))
        assert window.titles[-1] == f"gpu-xform - edges: {edges}"
    window = Window([ball, HOUSE])
    window.key("e")
    layers = [Layer(ball, edges="silhouette"), Layer(HOUSE, edges="feature")]
    np.testing.assert_array_equal(window.shown(), expected(layers))
    assert window.titles[-1] == "gpu-xform and 1 more - edges: feature"
    window.key("e")
    assert window.titles[-1] == "gpu-xform and 1 more - edges: silhouette"  # both are closed: they have no boundary


@pytest.mark.parametrize("name", ["q", "Escape"])
def test_q_closes(name: str) -> None:
    window = Window()
    window.shown()
    window.key(name)
    assert window.canvas.get_closed()
    assert not window.failures


def test_what_fails_in_drawing_closes_the_window_and_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    window = Window()
    window.shown()

    def lost(*_: object, **__: object) -> None:
        raise DeviceError("the device is lost")

    monkeypatch.setattr(session_module, "render_array", lost)
    window.key("e")
    window.shown()
    assert window.canvas.get_closed()
    assert [str(error) for error in window.failures] == ["the device is lost"]


def test_only_what_changes_the_picture_is_drawn_again() -> None:
    window = Window()
    window.shown()
    asked: list[None] = []
    window.canvas.request_draw = lambda: asked.append(None)
    window.do("pointer_move", x=3, y=3, button=0, buttons=())
    window.key("x", "s")
    assert not asked
    window.key("e")
    assert len(asked) == 1


@pytest.fixture
def _no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


@pytest.mark.usefixtures("_no_display")
def test_without_a_display_the_error_says_so() -> None:
    with pytest.raises(DisplayError, match=r"^no display: DISPLAY and WAYLAND_DISPLAY are not set; .*render.* without"):
        view(HOUSE)


@pytest.mark.usefixtures("_no_display")
def test_a_driver_that_draws_into_no_window_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":54321")
    monkeypatch.setattr(window_module, "find_instance_extensions", lambda: frozenset({"VK_KHR_xcb_surface"}))
    with pytest.raises(DisplayError, match=r"^no Vulkan driver here draws into windows of X11 \(VK_KHR_xlib"):
        view(HOUSE)


@pytest.mark.usefixtures("_no_display")
def test_a_display_that_does_not_answer_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(window_module, "find_instance_extensions", lambda: None)
    monkeypatch.setenv("DISPLAY", ":54321")
    with pytest.raises(DisplayError, match=r"^no display: [^'\"]*:54321;"):
        view(HOUSE)


@pytest.mark.parametrize("module", ["glfw", "rendercanvas"])
def test_without_its_libraries_the_error_says_what_to_install(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=r"pip install 'gpu_xform\[viewer\]'"):
        view(HOUSE)


def test_in_a_running_event_loop_the_error_says_where_to_call_it() -> None:
    import asyncio

    async def cell() -> None:
        view(HOUSE)

    with pytest.raises(DisplayError, match="notebook"):
        asyncio.run(cell())


@pytest.mark.parametrize(
    ("models", "arguments", "error"),
    [
        ("no such file.obj", {}, FileNotFoundError),
        ([], {}, ArgumentError),
        (Mesh(np.empty((0, 3)), []), {}, MeshError),
        (HOUSE, {"edges": "boundary"}, MeshError),
        (HOUSE, {"camera": "front"}, ArgumentTypeError),
        (HOUSE, {"up": (0, 0, 0)}, ArgumentError),
        (HOUSE, {"size": (0, 10)}, ArgumentError),
        (HOUSE, {"background": "no colour"}, ArgumentError),
        (HOUSE, {"color": "no colour"}, ArgumentError),
        (HOUSE, {"colour": "red"}, TypeError),
    ],
)
def test_what_cannot_be_drawn_is_said_before_there_is_a_window(
    models: Models, arguments: dict[str, Any], error: type[Exception], screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", screen.display)

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("there is a window")

    monkeypatch.setattr(glfw, "create_window", refuse)
    try:
        with pytest.raises(error):
            view(models, **arguments)
    finally:
        glfw.terminate()  # Xlib ends the process where its server goes first


USE = """
import gpu_xform as gx
gx.view("ball.obj", size=(320, 240), color="face")
print("closed")
"""


USE_TWICE = """
import gpu_xform as gx
from gpu_xform.viewer import session
house = gx.samples.house()
gx.view(house, size=(200, 150))
draw = session.render_array
def fail_at_a_key(layers, **arguments):
    if layers[0].edges == "feature":
        raise gx.DeviceError("the device is lost")
    return draw(layers, **arguments)
session.render_array = fail_at_a_key
try:
    gx.view(house, size=(210, 140))
except gx.DeviceError as error:
    print(error)
"""


class Shown:
    """A program that shows a window on a screen, in the upper left corner of which it is."""

    def __init__(self, screen: Screen, *command: str) -> None:
        self.screen = screen
        environment = {**os.environ, "DISPLAY": screen.display}
        environment.pop("WAYLAND_DISPLAY", None)
        pipe = subprocess.PIPE
        self.program = subprocess.Popen(command, env=environment, stdout=pipe, stderr=pipe, text=True)

    def wait_for(self, picture: Pixels) -> None:
        """Wait until the window shows `picture`, to the last bit."""
        height, width = picture.shape[:2]

        def is_there() -> bool:
            assert self.program.poll() is None, self.program.communicate()
            return np.array_equal(self.screen.screenshot()[:height, :width], picture[..., :3])

        self.screen.wait_for(is_there)

    def ended(self) -> tuple[int, str, str]:
        """Return the exit code of the program, which must come to its end, and what it printed."""
        output, errors = self.program.communicate(timeout=60)
        return self.program.returncode, output, errors


@pytest.fixture
def shown(screen: Screen) -> Iterator[Callable[..., Shown]]:
    require_windows()
    made: list[Shown] = []

    def show(*command: str) -> Shown:
        made.append(Shown(screen, *command))
        return made[-1]

    yield show
    for program in made:
        if program.program.poll() is None:
            program.program.kill()
        program.program.communicate()


def test_a_real_window_turns_zooms_changes_its_style_saves_and_closes(
    shown: Callable[..., Shown], screen: Screen, tmp_path: Path
) -> None:
    ball = samples.snub_dodecahedron()
    save_mesh(ball, "ball.obj")
    window = shown(sys.executable, "-W", "error", "-c", USE)
    size, style = (320, 240), {"color": "face"}
    window.wait_for(expected(ball, size, **style))
    screen.wait_for(lambda: "ball - H shows the keys" in screen.xdotool("search", "--name", "ball", "getwindowname"))

    screen.xdotool("mousemove", "100", "100", "mousedown", "1", "mousemove", "150", "110", "mouseup", "1")
    orbit = Orbit.from_camera(Camera.fit(ball), 4 / 3, BoundingSphere.around(ball.positions))
    orbit = orbit.rotated(np.pi * 50 / 240, np.pi * 10 / 240)
    window.wait_for(expected(ball, size, camera=orbit.camera, **style))

    screen.xdotool("mousemove", "80", "60", "click", "4")
    orbit = orbit.zoomed(1 / 1.2, np.array([-0.5, 0.5]), 4 / 3)
    window.wait_for(expected(ball, size, camera=orbit.camera, **style))

    screen.xdotool("keydown", "shift", "mousedown", "1", "mousemove", "160", "120", "mouseup", "1", "keyup", "shift")
    orbit = orbit.panned(np.array([-0.5, 0.5]), np.zeros(2), 4 / 3)
    window.wait_for(expected(ball, size, camera=orbit.camera, **style))

    screen.xdotool("key", "c", "key", "f", "key", "d")
    style = {"fill": "lightgray", "hidden": "dash"}
    window.wait_for(expected(ball, size, camera=orbit.camera, **style))
    screen.xdotool("key", "s", "key", "p")
    orbit = dataclasses.replace(orbit, orthographic=True)
    window.wait_for(expected(ball, size, camera=orbit.camera, **style))
    assert (tmp_path / "ball-1.png").exists()

    [name] = screen.xdotool("search", "--name", "ball").split()
    screen.xdotool("windowsize", name, "200", "260")
    window.wait_for(expected(ball, (200, 260), camera=orbit.camera, **style))
    screen.xdotool("key", "q")
    assert window.ended() == (0, "closed\n", "")


def test_an_interrupt_closes_the_window_and_ends_in_one_line(shown: Callable[..., Shown]) -> None:
    save_mesh(HOUSE, "house.obj")
    window = shown(sys.executable, "-W", "error", "-m", "gpu_xform", "view", "house.obj", "--resolution", "200x150")
    window.wait_for(expected(size=(200, 150)))
    window.program.send_signal(signal.SIGINT)
    assert window.ended() == (130, "", "gpu-xform: interrupted\n")


def test_a_second_window_opens_after_the_first_and_a_lost_device_is_raised(
    shown: Callable[..., Shown], screen: Screen
) -> None:
    window = shown(sys.executable, "-W", "error", "-c", USE_TWICE)
    window.wait_for(expected(size=(200, 150)))
    screen.xdotool("mousemove", "50", "50", "key", "q")
    window.wait_for(expected(size=(210, 140)))
    screen.xdotool("mousemove", "60", "50", "key", "e")
    assert window.ended() == (0, "the device is lost\n", "")


def test_the_command_opens_a_window(shown: Callable[..., Shown], screen: Screen) -> None:
    save_mesh(HOUSE, "house.obj")
    options = ["--resolution", "300x200", "--up", "+Z", "--edges", "feature", "--background-color", "navy", "--color"]
    window = shown(sys.executable, "-W", "error", "-m", "gpu_xform", "view", "house.obj", *options, "white")
    assert main(["render", "house.obj", "-o", "house.png", *options, "white"]) == 0
    with Image.open("house.png") as picture:
        window.wait_for(np.asarray(picture))
    screen.xdotool("mousemove", "100", "100", "key", "1")
    upright = Camera.fit(HOUSE, direction=(-1, 1, -1), up=(0, 0, 1))
    orbit = Orbit.from_camera(upright, 1.5, BoundingSphere.around(HOUSE.positions)).seen_from(
        "front", HOUSE.positions, 1.5
    )
    window.wait_for(expected(size=(300, 200), camera=orbit.camera, edges="feature", background="navy", color="white"))
    screen.xdotool("key", "Escape")
    assert window.ended() == (0, "", "")
