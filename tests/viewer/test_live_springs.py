"""Springs in a window: they move in real time, and a point follows the pointer."""

import subprocess
import sys
import time
from typing import Any, Unpack

import numpy as np
import pytest
from rendercanvas.offscreen import OffscreenRenderCanvas

import gpu_xform as gx
from gpu_xform.drawing.layer import Style
from gpu_xform.gpu.device import require_gpu_device
from gpu_xform.viewer import live_springs
from gpu_xform.viewer.canvas import connect
from gpu_xform.viewer.session import Session
from tests.support.device_memory import count_bytes
from tests.support.spring_models import make_cloth
from tests.support.types import Array, Pixels
from tests.support.xvfb import Screen, require_windows

SIZE = (160, 120)
CAMERA = gx.Camera.look_at((0.5, 0.4, 2.2), (0.5, -0.2, 0.5), fov_y=40)
PARALLEL = gx.Camera.fit(gx.samples.cloth(4, 4), direction=(0.3, -1, -0.4), orthographic=True, margin=0.3)


class Window:
    """A window that nobody sees, with a clock that is set by hand."""

    def __init__(self, models: Any, conditions: Any = None, camera: gx.Camera = CAMERA, **style: Unpack[Style]) -> None:
        self.time = 100.0
        self.camera = camera
        self.session = Session(
            models, camera, None, SIZE, "white", None, "auto", style, conditions, clock=lambda: self.time
        )
        self.canvas = OffscreenRenderCanvas(size=SIZE)
        self.titles: list[str] = []
        self.canvas._rc_set_title = self.titles.append
        self.failures = connect(self.canvas, self.session)

    def do(self, kind: str, **event: Any) -> None:
        self.canvas.submit_event({"event_type": kind, "modifiers": (), **event})
        self.canvas._process_events()

    def pointer(self, kind: str, at: Array, **event: Any) -> None:
        held = {"button": 0 if kind == "move" else 1, "buttons": () if kind == "up" else (1,)}
        self.do(f"pointer_{kind}", x=float(at[0]), y=float(at[1]), **{**held, **event})

    def after(self, seconds: float) -> Pixels:
        """Let time pass, and return what is shown then."""
        self.time += seconds
        return np.asarray(self.canvas.draw())

    def run(self, n_pictures: int) -> Pixels:
        return [self.after(1.0 / 30.0) for _ in range(n_pictures)][-1]

    def place_of(self, point: Array, matrix: Array | None = None) -> Array:
        """Return the pixel in which a point is shown."""
        x, y, _, w = (
            self.camera.clip_from_world(SIZE[0] / SIZE[1]) @ (np.eye(4) if matrix is None else matrix) @ [*point, 1.0]
        )
        return np.array([(x / w + 1.0) * SIZE[0], (1.0 - y / w) * SIZE[1]]) / 2.0


def expected(models: Any, **style: Any) -> Pixels:
    return gx.render_array(models, camera=CAMERA, size=SIZE, **style)


def test_space_starts_and_stops_and_0_goes_back() -> None:
    springs, twin = make_cloth(12, pinned=[0, 11]), make_cloth(12, pinned=[0, 11])
    window = Window(springs, hidden="remove")
    first = window.after(0.0)
    np.testing.assert_array_equal(window.after(1.0), expected(twin, hidden="remove"))  # it has not started
    assert window.titles[-1] == "gpu-xform - space starts, H shows the keys"
    window.do("key_down", key=" ")
    moved = window.run(6)
    twin.simulate(0.2, 60.0)
    np.testing.assert_array_equal(springs.positions, twin.positions)
    np.testing.assert_array_equal(moved, expected(twin, hidden="remove"))
    assert window.titles[-1] == "gpu-xform - space stops, H shows the keys"
    assert (moved != first).any()
    window.do("key_down", key=" ")
    np.testing.assert_array_equal(window.after(5.0), moved)
    window.do("key_down", key=" ")
    window.run(3)  # the pause is no time
    twin.simulate(0.1, 60.0)
    np.testing.assert_array_equal(springs.positions, twin.positions)
    window.do("key_down", key="0")
    np.testing.assert_array_equal(window.after(1.0), first)
    assert not window.failures


def test_it_asks_for_pictures_while_it_moves_and_only_then() -> None:
    window = Window(make_cloth(8))
    window.after(0.0)
    asked: list[None] = []
    window.canvas.request_draw = lambda: asked.append(None)
    window.after(0.1)
    assert not asked
    window.do("key_down", key=" ")
    asked.clear()
    window.run(3)
    assert len(asked) == 3


def test_what_cannot_be_made_up_for_is_left_out_and_said() -> None:
    springs = make_cloth(8)
    window = Window(springs)
    window.do("key_down", key=" ")
    window.after(10.0)
    assert springs.time == pytest.approx(live_springs.MAX_FRAMES_PER_PICTURE / 60.0)
    window.after(1.0 / 60.0)
    assert any("slower than real time" in title for title in window.titles)
    assert "slower" not in window.titles[-1]
    assert springs.time == pytest.approx((live_springs.MAX_FRAMES_PER_PICTURE + 1) / 60.0)


@pytest.mark.parametrize("camera", [CAMERA, PARALLEL], ids=["perspective", "parallel"])
@pytest.mark.parametrize("n", [8, 24])
def test_a_point_that_is_dragged_stays_under_the_pointer(n: int, camera: gx.Camera) -> None:
    springs = make_cloth(n, pinned=[0, n - 1], damping=1e-4)
    window = Window(springs, camera=camera)
    window.do("key_down", key=" ")
    window.run(2)
    point = n * n - n // 2
    start = window.place_of(springs.positions[point])
    window.pointer("down", start + 0.2)
    [(held, _)] = springs._held.items()
    assert np.linalg.norm(window.place_of(springs.positions[held]) - start) < 1.0
    before = springs.positions[held]
    for k in range(1, 11):
        window.pointer("move", start + 0.2 + np.array([1.5 * k, -1.0 * k]))
        window.run(1)
    window.run(8)
    place = window.place_of(springs.positions[held])
    np.testing.assert_allclose(place - window.place_of(before), (15.0, -10.0), atol=0.05)
    depth = (
        camera.clip_from_world(SIZE[0] / SIZE[1])[2:] @ np.array([[*before, 1.0], [*springs.positions[held], 1.0]]).T
    )
    np.testing.assert_allclose(depth[:, 0], depth[:, 1], rtol=1e-4, atol=1e-4)  # as far away as it was
    window.pointer("up", start)
    assert not springs._held
    y = springs.positions[held, 1]
    window.run(6)
    assert springs.positions[held, 1] < y - 0.005  # it falls again
    assert window.session._controls.view.orbit is None  # the view has not turned
    assert not window.failures


def test_a_drag_beside_the_springs_and_one_with_shift_turn_and_move_the_view() -> None:
    springs = make_cloth(8)
    window = Window(springs)
    window.after(0.0)
    window.pointer("down", np.array([3.0, 3.0]))
    window.pointer("move", np.array([30.0, 3.0]))
    window.pointer("up", np.array([30.0, 3.0]))
    assert not springs._held
    turned = window.session._controls.view.orbit
    assert turned is not None
    window.do("key_down", key="r")
    place = window.place_of(springs.positions[30])
    window.pointer("down", place, modifiers=("Shift",))
    assert not springs._held
    window.pointer("up", place)


def test_of_two_points_in_one_place_the_one_in_front_is_dragged() -> None:
    far, near = np.array([0.1, 0.0, -1.0]), np.array([0.1, 0.0, 1.0])
    springs = gx.Springs([far, near], springs=[[0, 1]], stiffness=1.0, mass=1.0)
    camera = gx.Camera.fit([far, near], direction=(0, 0, -1), orthographic=True, margin=0.3)
    window = Window([springs, gx.samples.cube()], camera=camera)
    window.pointer("down", window.place_of(far))
    assert list(springs._held) == [1]


def test_springs_that_stand_elsewhere_are_dragged_there() -> None:
    springs = make_cloth(8)
    matrix = gx.translate(0.2, 0.3, -0.5) @ gx.rotate_y(0.4) @ gx.scale(1.1)
    window = Window(gx.Layer(springs, transform=matrix))
    start = window.place_of(springs.positions[60], matrix)
    window.pointer("down", start)
    window.pointer("move", start + np.array([5.0, -7.0]))
    np.testing.assert_allclose(window.place_of(springs.positions[60], matrix), start + np.array([5.0, -7.0]), atol=0.05)
    assert springs.time == 0.0  # the simulation has not started: the point alone moves


def test_a_wild_drag_does_not_blow_the_cloth_up() -> None:
    springs = make_cloth(20, damping=1e-4)
    window = Window(springs)
    window.do("key_down", key=" ")
    window.after(0.0)
    window.pointer("down", window.place_of(springs.positions[210]))
    rng = np.random.default_rng(3)
    for _ in range(40):
        window.pointer("move", rng.uniform(-300, 500, 2))
        window.run(1)
    assert np.isfinite(springs.positions).all()
    assert np.abs(springs.positions).max() < 20.0
    assert window.session._live.is_running


def test_a_release_outside_the_window_is_noticed() -> None:
    springs = make_cloth(8)
    window = Window(springs)
    window.pointer("down", window.place_of(springs.positions[30]))
    assert list(springs._held) == [30]
    window.pointer("move", np.array([10.0, 10.0]), buttons=())
    assert not springs._held
    window.pointer("down", window.place_of(springs.positions[30]))
    window.session.close()
    assert not springs._held


def test_several_springs_move_under_the_conditions_that_are_given() -> None:
    ball = gx.Sphere((0.5, -0.2, 0.5), 0.15, gap=0.01)
    conditions = {"drag": 1.0, "wind": (0.0, 0.0, 6.0), "obstacles": ball}
    one, other, twin = make_cloth(8), make_cloth(10), make_cloth(10)
    window = Window([one, gx.samples.cube(), other], conditions)
    window.do("key_down", key=" ")
    window.run(10)
    twin.simulate(20 / 60.0, 60.0, **conditions)  # type: ignore[arg-type]
    np.testing.assert_array_equal(other.positions, twin.positions)
    assert one.time == other.time == twin.time


def test_what_is_not_finite_goes_back_to_the_start_and_is_said() -> None:
    springs = make_cloth(8)
    window = Window(springs, {"force": lambda *_: np.full((64, 3), 1e38)})
    window.do("key_down", key=" ")
    window.run(3)
    assert "is not at a finite position" in window.titles[-1]
    np.testing.assert_array_equal(springs.positions, make_cloth(8).positions)
    assert not window.session.is_moving
    assert not window.failures


def test_what_a_force_should_not_return_goes_back_to_the_start_and_is_said() -> None:
    window = Window(make_cloth(4), {"force": lambda time, *_: np.zeros((16 if time == 0.0 else 3, 3))})
    window.do("key_down", key=" ")
    window.run(3)
    assert "force must have shape (16, 3), got (3, 3), returned at" in window.titles[-1]
    assert not window.session.is_moving
    assert not window.failures


@pytest.mark.parametrize(
    ("models", "conditions", "message"),
    [
        (gx.samples.cube(), {"drag": 1.0}, r"^conditions say what acts on springs, and there are none$"),
        (make_cloth(4), {"drag": -1.0}, r"^drag must not be negative, got -1$"),
        (make_cloth(4), {"wind": (0, 0, 1)}, r"^wind must come with a drag"),
    ],
)
def test_impossible_conditions_are_said_before_there_is_a_window(models: Any, conditions: Any, message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        Window(models, conditions)


def test_keywords_that_are_no_conditions_are_said() -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"^unexpected keyword argument 'fps'$"):
        Window(make_cloth(4), {"fps": 30})


def test_the_help_has_the_keys_of_the_simulation() -> None:
    window, plain = Window(make_cloth(4)), Window(make_cloth(4).mesh)
    for shown in (window, plain):
        shown.canvas.set_logical_size(700, 700)
        shown.do("key_down", key="h")
    assert (window.after(0.0) != plain.after(0.0)).any()


def test_a_long_drag_does_not_grow_memory() -> None:
    springs = make_cloth(20, damping=1e-4)
    window = Window(springs, hidden="remove")
    window.do("key_down", key=" ")
    context = require_gpu_device(springs.device).context
    start = window.place_of(springs.positions[210])

    def drag(n: int) -> int:
        for k in range(n):
            window.pointer("down", window.place_of(springs.positions[210]))
            window.pointer("move", start + np.array([k % 7, k % 5]))
            window.run(2)
            window.pointer("up", start)
        return count_bytes(context)

    settled = [drag(8) for _ in range(4)]
    assert settled[-1] <= settled[1]


USE = """
import gpu_xform as gx
cloth = gx.Springs(gx.samples.cloth(10, 10), mass=0.1, stretch=50, damping=1e-3, pinned=[0, 10])
gx.view(cloth, size=(320, 240), conditions={"drag": 1.0}, camera={"direction": (0, -1, -2), "margin": 0.3})
print(cloth.time > 0.2, cloth.positions[:, 1].min() < -0.05)
"""


@pytest.fixture
def _screen_environment(screen: Screen, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", screen.display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


@pytest.mark.usefixtures("_screen_environment", "working_folder")
def test_a_real_window_simulates_until_it_is_closed(screen: Screen) -> None:
    require_windows()
    pipe = subprocess.PIPE
    program = subprocess.Popen([sys.executable, "-W", "error", "-c", USE], stdout=pipe, stderr=pipe, text=True)
    try:
        screen.wait_for(lambda: (screen.screenshot()[:240, :320] == 255).mean() > 0.5)
        screen.wait_for(lambda: "space starts" in screen.xdotool("search", "--name", "gpu-xform", "getwindowname"))
        first = screen.screenshot()[:240, :320]
        screen.xdotool("mousemove", "160", "120", "key", "space")
        screen.wait_for(lambda: (screen.screenshot()[:240, :320] != first).mean() > 0.02)
        time.sleep(3.0)
        screen.xdotool("key", "q")
        output, errors = program.communicate(timeout=60)
    finally:
        program.kill()
    assert (program.returncode, output, errors) == (0, "True True\n", "")
