"""The public face: what is refused, what is kept when something goes wrong, pins, states, trajectories."""

import copy
import math
import pickle
import signal
import threading
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.geometry.scene_animation import Channel, Placement, SceneAnimation
from gpu_xform.simulation.step_choice import MAX_SUBSTEPS
from tests.support.device_memory import count_bytes
from tests.support.spring_models import cloth_mesh, make_chain, make_cloth

NAN = float("nan")
POINTS = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 2.0, 0.0]]
SQUARE = cloth_mesh(2)


def pair(**options: Any) -> gx.Springs:
    return gx.Springs(**{"model": POINTS[:2], "springs": [[0, 1]], "stiffness": 3.0, "mass": 1.0, **options})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"model": [[0.0, 0.0]]}, r"^model must have shape \(n, 3\), got \(1, 2\)$"),
        ({"model": np.empty((0, 3))}, r"^model must have at least one point, got none$"),
        (
            {"model": [[0, 0, NAN]], "springs": None, "stiffness": None},
            r"^model must be finite, got nan at index \(0, 2\)",
        ),
        ({"springs": [[0, 2]]}, r"^springs must name points in 0..1, got \(0, 2\) for spring 0$"),
        ({"springs": [[0, 1], [-1, 1]]}, r"^springs must name points in 0..1, got \(-1, 1\) for spring 1$"),
        ({"springs": [[0, 1], [1, 1]]}, r"^springs must join two points each, got point 1 twice for spring 1$"),
        ({"springs": [0, 1]}, r"^springs must have shape \(s, 2\), got \(2,\)$"),
        (
            {"model": POINTS, "springs": [[0, 1], [3, 2]]},
            r"^springs must join points that lie apart, got points 3 and 2 in one place$",
        ),
        (
            {"model": gx.Mesh(POINTS, [[0, 1, 2, 3]]), "stretch": 1.0},
            r"^model must join points that lie apart, got points 2 ",
        ),
        ({"stiffness": None}, r"^stiffness must be given with springs, in newtons per metre, got none$"),
        ({"stiffness": -1.0}, r"^stiffness must not be negative, got -1 for spring 0$"),
        ({"stiffness": NAN}, r"^stiffness must be finite, got nan$"),
        ({"stiffness": [1.0, 2.0]}, r"^stiffness must be one number or have shape \(1,\), one per spring, got \(2,\)$"),
        ({"rest": 0.0}, r"^rest must be positive, got 0 for spring 0$"),
        ({"rest": [-0.5]}, r"^rest must be positive, got -0.5 for spring 0$"),
        ({"springs": None}, r"^stiffness and rest are those of springs, which are not given$"),
        ({"mass": None}, r"^mass \(kg\) or area_density \(kg/m\^2\) must be given, got neither$"),
        ({"area_density": 1.0}, r"^mass \(kg\) or area_density \(kg/m\^2\) must be given, got both$"),
        ({"mass": 0.0}, r"^mass must be positive, got 0$"),
        ({"mass": [1.0, -2.0]}, r"^mass must be positive, got -2 for point 1$"),
        ({"mass": [1.0, 2.0, 3.0]}, r"^mass must be one number or have shape \(2,\), one per point, got \(3,\)$"),
        ({"mass": None, "area_density": 1.0}, r"^area_density needs a mesh, whose faces have areas$"),
        ({"damping": -1e-3}, r"^damping must not be negative, got -0.001$"),
        ({"pinned": [0, 1]}, r"^pinned must leave a point free, got all 2$"),
        ({"pinned": [2]}, r"^pinned must lie in 0..1, got 2$"),
        ({"pinned": [True]}, r"^pinned must be a mask of shape \(2,\), or indices, got \(1,\)$"),
        ({"model": [[0, 0, 0], [1e39, 0, 0]]}, r"^model must hold numbers of at most 1e\+18 in size, got 1e\+39$"),
        ({"stiffness": 1e40}, r"^stiffness must be at most 3.4e\+38, got 1e\+40$"),
        ({"rest": [1e300]}, r"^rest must hold numbers of at most 3.4e\+38 in size, got 1e\+300$"),
        ({"mass": 1e-42}, r"^mass must give every point at least 1e-38 kg, got 5e-43 for point 0$"),
        ({"mass": 1e300}, r"^mass must be at most 3.4e\+38, got 1e\+300$"),
        ({"damping": 1e300}, r"^damping must be at most 3.4e\+38, got 1e\+300$"),
        ({"pinned": [[0], [0, 1]]}, r"^pinned must be a rectangular array of indices: "),
        ({"springs": [[0, 1], [0]]}, r"^springs must be a rectangular array of indices: "),
        (
            {"springs": np.array([[0, 2**63 + 1]], np.uint64)},
            r"^springs must name points in 0..1, got \(0, 9223372036854775809\) for spring 0$",
        ),
        (
            {"model": [[1e6, 0, 0], [1e6 + 1e-3, 0, 0]]},
            r"^springs must join .* got points 0 and 1 in one place as float32, near \[1000000.0, 0.0, 0.0\]$",
        ),
        ({"velocities": [[0.0, 0.0, 1.0]]}, r"^velocities must have shape \(2, 3\), got \(1, 3\)$"),
        ({"velocities": [[0, 0, 1], [0, 0, math.inf]]}, r"^velocities must be finite, got inf at index \(1, 2\)$"),
        ({"stretch": 1.0}, r"^stretch, shear and bend need a mesh, whose edges and faces they join$"),
        (
            {"model": SQUARE, "springs": None, "stiffness": None},
            r"^stretch must be given for a mesh, in newtons per metre",
        ),
        ({"model": SQUARE, "stretch": 1.0, "shear": -1.0}, r"^shear must not be negative, got -1$"),
        (
            {"model": gx.Mesh(POINTS[:3], [[0, 1]]), "stretch": 1.0, "mass": None, "area_density": 1.0},
            r"^area_density must give every point a mass, got 0 for point 0$",
        ),
    ],
)
def test_an_impossible_system_is_an_error(options: dict[str, Any], message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        pair(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"springs": [[0.0, 1.0]]}, r"^springs must hold indices of points, got dtype float64$"),
        ({"pinned": [0.5]}, r"^pinned must hold indices of points, got dtype float64$"),
        ({"mass": "heavy"}, r"^mass must hold real numbers, got dtype <U5$"),
        ({"device": "gpu"}, r"^device must be a Device, got 'gpu'$"),
    ],
)
def test_a_wrong_type_is_an_error(options: dict[str, Any], message: str) -> None:
    with pytest.raises(gx.ArgumentTypeError, match=message):
        pair(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"duration": 0.0}, r"^duration must be positive, got 0$"),
        ({"duration": NAN}, r"^duration must be finite, got nan$"),
        ({"fps": -1.0}, r"^fps must be positive, got -1$"),
        ({"gravity": (0, 1)}, r"^gravity must have shape \(3,\), got \(2,\)$"),
        ({"drag": 1.0}, r"^drag must be 0 without faces; drag_rate acts on points, got 1$"),
        ({"drag_rate": -1.0}, r"^drag_rate must not be negative, got -1$"),
        ({"wind": (1, 0, 0)}, r"^wind must come with a drag or a drag_rate, through which it acts, got neither$"),
        ({"wind": lambda t: (t, 0), "drag_rate": 1.0}, r"^wind must have shape \(3,\), got \(2,\), returned at 0 s$"),
        ({"move_pins": lambda _: np.eye(4)}, r"^move_pins needs pinned points$"),
        ({"force": lambda *_: np.zeros(3)}, r"^force must have shape \(2, 3\), got \(3,\), returned at 0 s$"),
        ({"force": lambda *_: 1 / 0}, r"^force raised at 0 s: ZeroDivisionError: division by zero$"),
        ({"substeps": 0}, r"^substeps must be at least 1, got 0$"),
        ({"substeps": 10**30}, r"^substeps must be at most 10,000,000, got 10+$"),
        ({"fps": 1e-300}, r"^fps must be at least 1e-06, got 1e-300$"),
        ({"gravity": (0, 1e300, 0)}, r"^gravity must hold numbers of at most 1e\+18 in size, got 1e\+300$"),
        ({"wind": (1e39, 0, 0), "drag_rate": 1}, r"^wind must hold numbers of at most 1e\+18 in size, got 1e\+39$"),
        ({"drag_rate": 1e300}, r"^drag_rate must be at most 3.4e\+38, got 1e\+300$"),
        ({"drag_rate": 1e30}, r"^a frame needs 1.7e\+28 steps, more than max_substeps, 10,000: drag_rate is 1e\+30"),
        ({"force": lambda *_: np.full((2, 3), 1e39)}, r"^force must hold .* got 1e\+39, returned at 0 s$"),
        ({"keep": np.zeros(3)}, r"^keep must be "),
        ({"max_substeps": 10**30}, r"^max_substeps must be at most 10,000,000, got 10+$"),
        ({"max_substeps": 0}, r"^max_substeps must be at least 1, got 0$"),
    ],
)
def test_an_impossible_run_is_an_error(options: dict[str, Any], message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        pair().simulate(**{"duration": 1.0, **options})


def test_a_step_above_the_limit_is_an_error_that_names_the_largest() -> None:
    springs = pair(mass=[0.5, 0.5], stiffness=100.0)  # w = 20 / s
    with pytest.raises(gx.ArgumentError, match=r"^dt must be at most 0.1 s, the largest stable step, got 0.11$"):
        springs.step(1, 0.11)
    with pytest.raises(gx.ArgumentError, match=r"^substeps must be at least 10, for steps of at most 0.1 s, .* got 9$"):
        springs.simulate(1.0, 1.0, substeps=9)
    assert springs.time == 0.0
    springs.simulate(1.0, 1.0, substeps=10)


def test_too_many_substeps_are_an_error_that_names_the_stiffest_point() -> None:
    springs = gx.Springs(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        springs=[[0, 1], [1, 2]],
        stiffness=[1e10, 2e10],
        mass=[1.0, 0.1, 1.0],
    )
    message = (
        r"^a frame needs .* steps, more than max_substeps, 10,000: point 1 has springs of 3e\+10 N/m in sum and a mass"
    )
    with pytest.raises(gx.ArgumentError, match=message) as caught:
        springs.simulate(1.0)
    assert caught.value.argument == "max_substeps"


def test_the_largest_step_allows_for_pins_masses_and_damping() -> None:
    free = pair(mass=[0.5, 2.0], stiffness=100.0)
    assert free.largest_step == pytest.approx(2.0 / math.sqrt(2.0 * 100.0 / 0.5))
    pinned = pair(mass=[0.5, 2.0], stiffness=100.0, pinned=[1])
    assert pinned.largest_step == pytest.approx(2.0 / math.sqrt(100.0 / 0.5))
    damped = pair(mass=[0.5, 2.0], stiffness=100.0, pinned=[1], damping=0.1)
    w, z = math.sqrt(200.0), 0.1 * math.sqrt(200.0) / 2.0
    assert damped.largest_step == pytest.approx(2.0 / w * (math.sqrt(1.0 + z * z) - z))
    assert gx.Springs(POINTS, mass=1.0).largest_step == math.inf


def test_substeps_are_the_fewest_that_are_stable() -> None:
    springs = pair(mass=[0.5, 0.5], stiffness=100.0)
    springs.simulate(0.5, 2.0)
    assert springs.substeps == math.ceil(0.5 / (0.98 * 0.1))


def test_a_result_that_is_not_finite_names_the_frame_and_keeps_the_frames_before() -> None:
    springs = make_cloth(4)
    blow = 3

    def force(time: float, positions: Any, _: Any) -> Any:
        return np.full_like(positions, 3e38 if round(30 * time) >= blow else 0.0)

    with pytest.raises(
        gx.SimulationError, match=r"^point 0 is not at a finite position in frame 4, at 0.133333 s"
    ) as caught:
        springs.simulate(1.0, force=force)
    assert caught.value.frame == 4
    assert springs.trajectory is not None
    assert springs.trajectory.shape == (4, 16, 3)
    np.testing.assert_allclose(springs.trajectory.times, np.arange(4) / 30.0)
    with pytest.raises(gx.SimulationError, match=r"^point 0 is not at a finite position at the start, at "):
        springs.simulate(1.0)
    springs.reset()
    assert np.isfinite(springs.simulate(0.1)).all()


def test_ctrl_c_keeps_what_is_done() -> None:
    springs, whole = make_cloth(6, pinned=[0, 5]), make_cloth(6, pinned=[0, 5])
    done = []

    def progress(k: int, n: int) -> None:
        done.append((k, n))
        if k == 3:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        springs.simulate(1.0, progress=progress)
    assert done == [(1, 30), (2, 30), (3, 30)]
    assert springs.trajectory is not None
    assert len(springs.trajectory) == 4
    rest = springs.simulate(0.1)
    np.testing.assert_array_equal([*springs.trajectory][-1], rest[-1])
    expected = whole.simulate(0.2)
    np.testing.assert_array_equal(rest.positions[-1], expected.positions[-1])


@pytest.mark.parametrize("moment", ["step", "read"])
def test_ctrl_c_within_a_frame_leaves_the_state_of_the_last_that_is_kept(
    moment: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    springs, whole = (make_cloth(6, pinned=[0, 5], damping=1e-5) for _ in range(2))
    step, read = springs._stepper.step, springs._stepper.read_positions
    n_parts = n_reads = 0

    def interrupt(n_steps: int, step_s: float, conditions: Any, count: Any) -> None:
        def count_and_interrupt(n: int) -> None:
            nonlocal n_parts
            n_parts += 1
            if n_parts == 5:  # of three per frame
                signal.raise_signal(signal.SIGINT)
            count(n)

        step(n_steps, step_s, conditions, count_and_interrupt)

    def interrupt_read() -> Any:
        nonlocal n_reads
        n_reads += 1
        if n_reads == 3:
            signal.raise_signal(signal.SIGINT)
        return read()

    options: dict[str, Any] = {"fps": 20.0, "substeps": 600}
    with monkeypatch.context() as patch:
        if moment == "step":
            patch.setattr(springs._stepper, "step", interrupt)
        else:
            patch.setattr(springs._stepper, "read_positions", interrupt_read)
        with pytest.raises(KeyboardInterrupt):
            springs.simulate(0.25, **options)
    path = springs.trajectory
    assert path is not None
    assert len(path) == 3
    assert springs.time == path.times[-1] == pytest.approx(0.1)
    assert springs.positions.tobytes() == path[-1].tobytes()
    expected = whole.simulate(0.25, **options)
    rest = springs.simulate(0.15, **options)
    assert rest.positions.tobytes() == expected.positions[2:].tobytes()
    assert springs.state() == whole.state()


def test_ctrl_c_within_steps_is_raised_after_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    springs, whole = make_cloth(6), make_cloth(6)
    step = springs._stepper.step

    def interrupt(*arguments: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        step(*arguments)

    monkeypatch.setattr(springs._stepper, "step", interrupt)
    with pytest.raises(KeyboardInterrupt):
        springs.step(7)
    whole.step(7)
    assert springs.state() == whole.state()


def test_steps_are_short_enough_for_a_strong_wind() -> None:
    flag = gx.Springs(gx.samples.cloth(12, 12), mass=0.1, stretch=300, shear=30, bend=1, damping=2e-4, pinned=range(13))
    blow: dict[str, Any] = {"drag": 1.5, "wind": (0, 100, 100)}
    calm = flag.count_substeps()
    area_per_mass = (1 / 144) / (0.1 / 169)
    rate = 1.5 * 1.2 * math.hypot(100, 100) * area_per_mass
    w = (
        2.0
        / gx.Springs(gx.samples.cloth(12, 12), mass=0.1, stretch=300, shear=30, bend=1, pinned=range(13)).largest_step
    )
    half_decay = (2e-4 * w * w + rate) / 2.0
    largest = 2.0 / (math.hypot(w, half_decay) + half_decay)
    assert flag.count_substeps(**blow) == math.ceil(1 / 30 / (0.98 * largest)) > 1.5 * calm
    assert flag.count_substeps(drag=1.5, wind=lambda _: (0, 100, 100)) == calm  # not known beforehand
    assert np.isfinite(flag.simulate(0.3, 30, **blow)).all()
    flag.reset()
    message = r"^point \d+ is not at .* in frame \d, at .*: more substeps than \d+, or less wind or drag, may help"
    with pytest.raises(gx.SimulationError, match=message):
        flag.simulate(0.3, 30, substeps=calm, **blow)


def test_wind_does_nothing_where_the_drag_is_given_as_0() -> None:
    calm, blown = make_cloth(4), make_cloth(4)
    expected = calm.simulate(0.1)
    still: list[dict[str, Any]] = [{"drag": 0.0}, {"drag_rate": 0}]
    for options in still:
        blown.reset()
        np.testing.assert_array_equal(blown.simulate(0.1, wind=(5, 0, 1), **options), expected)


@pytest.mark.parametrize(
    ("options", "argument", "words"),
    [
        ({"damping": 1e3}, "damping", r"damping is 1000\. Less damping would need fewer$"),
        ({"drag_rate": 1e9}, "drag_rate", r"drag_rate is 1e\+09\. Less drag_rate would need fewer$"),
        ({"drag": 1.0, "wind": (0, 1e9, 0)}, "drag", r"drag is 1\. Less drag, or less wind, would need fewer$"),
    ],
)
def test_too_many_substeps_are_blamed_on_what_asks_for_them(options: dict[str, Any], argument: str, words: str) -> None:
    springs = make_cloth(4, damping=options.get("damping", 0.0))
    options = {name: value for name, value in options.items() if name != "damping"}
    with pytest.raises(gx.ArgumentError, match=words) as caught:
        springs.simulate(0.1, **options)
    assert caught.value.argument == argument


@pytest.mark.parametrize("name", ["wind", "force", "move_pins"])
@pytest.mark.parametrize(("value", "words"), [(None, "returned None at 0.05 s"), (NAN, "nan .*, returned at 0.05 s")])
def test_what_a_function_should_not_return_is_an_error_that_names_it_and_the_time(
    name: str, value: float | None, words: str
) -> None:
    springs = make_cloth(3, pinned=[0])
    good = {"wind": np.zeros(3), "force": np.zeros((9, 3)), "move_pins": np.eye(4)}[name]

    def function(time: float, *_: Any) -> Any:
        return good if time < 0.02 else None if value is None else good * value

    options: dict[str, Any] = {name: function, "drag": 1.0}
    with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError), match=rf"^{name} .*{words}$") as caught:
        springs.simulate(0.2, 20.0, **options)
    assert caught.value.argument == name


@pytest.mark.parametrize("duration", [1e12, 1e300])
def test_a_run_that_no_memory_holds_is_an_error_that_names_the_duration(duration: float) -> None:
    springs = make_cloth(4)
    message = r"^duration must fit into memory, where its frames take .* bytes, got 1e\+\d+ s at 30 frames per second$"
    with pytest.raises(gx.ArgumentError, match=message):
        springs.simulate(duration)
    assert springs.time == 0.0


def test_a_run_shorter_than_half_a_frame_is_one_frame() -> None:
    assert len(make_cloth(4).simulate(1e-4, 30.0)) == 2


def test_a_state_in_a_file_continues_to_the_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options: dict[str, Any] = {"drag": 1.0, "wind": (2.0, 0.0, 0.0), "gravity": (0.0, -5.0, 1.0)}
    springs = make_cloth(8, damping=1e-4, pinned=[0, 7])
    springs.simulate(0.2, **options)
    (tmp_path / "cloth.state").write_bytes(springs.state())
    velocities = springs.velocities
    expected = springs.simulate(0.2, **options)

    other = make_cloth(8, damping=1e-4, pinned=[0, 7])
    monkeypatch.setattr("time.time", lambda: 2e9)
    other.restore((tmp_path / "cloth.state").read_bytes())
    assert other.time == pytest.approx(0.2)
    np.testing.assert_array_equal(other.velocities, velocities)
    assert other.state() == (tmp_path / "cloth.state").read_bytes()
    path = other.simulate(0.2, **options)
    assert path.positions.tobytes() == expected.positions.tobytes()
    np.testing.assert_array_equal(path.times, expected.times)


def test_a_state_of_another_system_and_no_state_are_errors() -> None:
    springs = make_cloth(4)
    for other, difference in (
        (make_cloth(5), "one of 25 points, not 16; 102 springs, not 58; 32 faces, not 18"),
        (make_cloth(4, bend=0.0), "one of 42 springs, not 58"),
        (make_cloth(4, damping=1e-5), "one with other damping"),
        (make_cloth(4, pinned=[3], stretch=2.0), "one with other pins, stiffness"),
        (make_cloth(4, mass=0.3), "one with other masses"),
    ):
        message = r"^state must be that of a system with the same points and springs, got "
        with pytest.raises(gx.ArgumentError, match=f"{message}{difference}$"):
            springs.restore(other.state())
    state = springs.state()
    for damage in (b"", b"PK", state[: len(state) // 2], b"\x93NUMPY" + state[6:]):
        message = rf"^state must be what Springs.state\(\) returned, got {len(damage):,} bytes that are something else"
        with pytest.raises(gx.ArgumentError, match=message):
            springs.restore(damage)
    with pytest.raises(gx.ArgumentTypeError, match=r"^state must be the bytes that state\(\) returns, got str$"):
        springs.restore("cloth.state")  # type: ignore[arg-type]


def test_a_state_that_is_not_finite_is_an_error() -> None:
    springs = pair(stiffness=0.0)
    with pytest.raises(gx.SimulationError):
        springs.simulate(2.0, 1.0, force=lambda *_: np.full((2, 3), 3e38))
    with pytest.raises(gx.SimulationError, match=r"^point 0 has no finite position and velocity, at \d s: restore an"):
        springs.state()


def test_pins_follow_a_matrix_of_the_time() -> None:
    springs = make_cloth(5, pinned=[0, 4], damping=1e-4)
    path = springs.simulate(0.5, 20.0, move_pins=lambda t: gx.translate(0.2 * t, t * t, 0.0) @ gx.rotate_x(t))
    for frame, time in zip(path, path.times, strict=True):
        corners = gx.transform_points(
            springs._system.points[[0, 4]], gx.translate(0.2 * time, time**2, 0.0) @ gx.rotate_x(time)
        )
        np.testing.assert_allclose(frame[[0, 4]], corners, atol=5e-6)
    held = springs.simulate(0.2, 20.0)  # nothing moves them any more
    np.testing.assert_array_equal(held.positions[:, [0, 4]], np.tile(held[0][[0, 4]], (5, 1, 1)))


def test_pins_follow_positions_and_pull_the_rest_along() -> None:
    springs = make_chain(3, length=0.1, stiffness=100.0, mass=0.01, damping=1e-2)
    springs.simulate(4.0, 10.0, gravity=(0, 0, 0), drag_rate=5.0, move_pins=lambda t: [[min(t, 1.0), 0.0, 0.0]])
    assert np.linalg.norm(springs.positions - [1.0, 0.0, 0.0], axis=1).max() < 0.31
    with pytest.raises(
        gx.ArgumentError,
        match=r"^move_pins must return a \(4, 4\) matrix or \(1, 3\) points, got \(2, 3\), returned at 4 s$",
    ):
        springs.step(1, move_pins=lambda _: np.zeros((2, 3)))


def test_a_force_is_called_once_a_frame_with_the_present_state() -> None:
    springs = gx.Springs([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], mass=[2.0, 1.0])
    calls: list[tuple[float, Any, Any]] = []

    def force(time: float, positions: Any, velocities: Any) -> Any:
        calls.append((time, positions, velocities))
        return [[3.0, 0.0, 0.0], [0.0, 0.0, 0.0]]

    springs.simulate(1.0, 4.0, gravity=(0, 0, 0), force=force, substeps=8)
    assert [time for time, *_ in calls] == [0.0, 0.25, 0.5, 0.75]
    np.testing.assert_allclose(springs.positions, [[0.75, 0.0, 0.0], [1.0, 0.0, 0.0]], rtol=1e-5)
    np.testing.assert_allclose(calls[-1][2], [[1.5 * 0.75, 0.0, 0.0], [0.0, 0.0, 0.0]], rtol=1e-5)


def test_bodies_that_are_joined_move_as_each_alone() -> None:
    cloth, chain = make_cloth(5, pinned=[0]), make_chain(6, length=0.1, stiffness=50.0, mass=0.02)
    both = gx.Springs.join([cloth, chain])
    assert (both.n_points, len(both.springs)) == (32, len(cloth.springs) + 6)
    assert both.mesh.n_faces == 16 + 6
    path = both.simulate(0.5, 10.0)
    np.testing.assert_allclose(path.positions[:, :25], cloth.simulate(0.5, 10.0, substeps=both.substeps), atol=2e-5)
    np.testing.assert_allclose(path.positions[:, 25:], chain.simulate(0.5, 10.0, substeps=both.substeps), atol=2e-5)
    with pytest.raises(gx.ArgumentError, match=r"^damping must be the same for all that are joined, got \[0.0, 0.1\]$"):
        gx.Springs.join([cloth, pair(damping=0.1)])
    with pytest.raises(gx.ArgumentError, match=r"^parts must hold at least one, got none$"):
        gx.Springs.join([])


def test_a_trajectory_is_an_array_and_a_sequence() -> None:
    springs = make_cloth(4, pinned=[0])
    path = springs.simulate(0.2, 20.0)
    array = np.asarray(path)
    assert array.shape == path.shape == (5, 16, 3)
    assert np.shares_memory(array, path.positions)
    assert not array.flags.writeable
    np.testing.assert_allclose(path.times, [0.0, 0.05, 0.1, 0.15, 0.2])
    assert np.array_equal(np.array(path, np.float64), array)
    assert len(path[1:3]) == 2
    assert path[1:3].times[0] == path.times[1]
    np.testing.assert_array_equal(path[-1], springs.positions)
    assert len(list(path)) == 5
    assert repr(path) == "<Trajectory: 5 frames of 16 points to 0.2 s>"


def test_the_meshes_of_a_trajectory_keep_what_stays_true() -> None:
    plain = cloth_mesh(3)
    mesh = plain.with_attributes({"point": {"normal": np.tile([0.0, 1.0, 0.0], (9, 1)), "heat": np.arange(9.0)}})
    path = gx.Springs(mesh, mass=0.1, stretch=10.0).simulate(0.1, 20.0)
    last = path.meshes()[-1]
    np.testing.assert_array_equal(last.positions, path[-1])
    np.testing.assert_array_equal(last.indices, mesh.indices)
    assert last.attributes.point.keys() == {"heat"}
    assert len(path.meshes()) == len(path.meshes()[0:]) == 3


@pytest.mark.usefixtures("device")
def test_the_frames_are_drawn_by_animate() -> None:
    springs = make_cloth(6, pinned=[0, 5])
    path = springs.simulate(0.2, 10.0)
    animation = gx.animate(springs.mesh, path.meshes(), size=(64, 48), hidden="remove")
    first, last = np.asarray(animation.frame(0)), np.asarray(animation.frame(2))
    assert len(animation) == 3
    assert (first != last).any()


def test_points_without_a_mesh_are_drawn_as_their_springs() -> None:
    springs = make_chain(3, length=0.1, stiffness=10.0, mass=0.1)
    np.testing.assert_array_equal(springs.mesh.edges, [[0, 1], [1, 2], [2, 3]])
    assert springs.simulate(0.1).meshes()[0].n_faces == 3


def test_energy_and_momentum_are_those_of_the_formulas() -> None:
    springs = pair(model=[[0, 1, 0], [2, 1, 0]], rest=1.5, mass=[1.0, 3.0], velocities=[[0, 0, 2], [1, 0, 0]])
    energy, momentum = springs.energy(), springs.momentum()
    assert energy.kinetic == pytest.approx(0.5 * 1 * 4 + 0.5 * 3 * 1)
    assert energy.elastic == pytest.approx(0.5 * 3.0 * 0.25)
    assert energy.potential == pytest.approx(4.0 * 9.81)
    assert energy.total == pytest.approx(sum(energy))
    np.testing.assert_allclose(momentum.linear, [3.0, 0.0, 2.0])
    np.testing.assert_allclose(momentum.angular, np.cross([0, 1, 0], [0, 0, 2]) + 3 * np.cross([2, 1, 0], [1, 0, 0]))


def test_positions_and_velocities_can_be_assigned() -> None:
    springs = pair(pinned=[0])
    springs.positions = [[0, 0, 0], [1, 1, 0]]
    springs.velocities = [[5, 5, 5], [0, 0, 1]]
    np.testing.assert_array_equal(springs.velocities, [[0, 0, 0], [0, 0, 1]])  # a pin has none
    np.testing.assert_array_equal(springs.positions, [[0, 0, 0], [1, 1, 0]])
    with pytest.raises(gx.ArgumentError, match=r"^positions must have shape \(2, 3\), got \(1, 3\)$"):
        springs.positions = [[0, 0, 0]]
    springs.reset()
    np.testing.assert_array_equal(springs.positions, POINTS[:2])


def test_a_model_too_large_for_the_device_is_an_error(device_with_limits: Any) -> None:
    for limits, most in (({"max_binding_bytes": 1 << 12}, 85), ({"max_texture_side": 1}, 682)):
        message = rf"^model must have at most {most} points with so many springs on .*, got 900$"
        with pytest.raises(gx.ArgumentError, match=message):
            make_cloth(30, device=device_with_limits(**limits))


@pytest.mark.usefixtures("device")
@pytest.mark.parametrize("kind", ["mappable", "staging", "single"])
def test_every_kind_of_device_moves_the_points_alike(kind: str, request: pytest.FixtureRequest) -> None:
    names = {"mappable": "device", "staging": "staging_device", "single": "single_device"}
    springs = make_cloth(6, pinned=[0], device=request.getfixturevalue(names[kind]))
    path = springs.simulate(0.2, obstacles=gx.Sphere((0, -0.2, 0.5), 0.15))
    expected = make_cloth(6, pinned=[0]).simulate(0.2, obstacles=gx.Sphere((0, -0.2, 0.5), 0.15))
    np.testing.assert_array_equal(path, expected)


def test_the_documented_cap_is_the_default() -> None:
    assert MAX_SUBSTEPS == 10_000


@pytest.mark.usefixtures("device")
def test_springs_are_drawn_as_they_are_at_present() -> None:
    springs = make_cloth(12, pinned=[0, 11])
    layer, scene = gx.Layer(springs, color="red"), gx.Scene()
    scene.add(springs, color="red")
    made = gx.animate(layer, [np.eye(4)], size=(120, 90))
    before = springs.mesh
    springs.simulate(0.2, 20.0)
    camera = gx.Camera.fit(springs.mesh)
    for drawn, mesh, style in (
        (springs, springs.mesh, {"color": "red", "hidden": "remove"}),
        ([springs], springs.mesh, {"fill": "gold"}),
        (scene, springs.mesh, {"color": "red"}),
        (layer, springs.mesh, {"color": "red"}),
    ):
        own = {} if isinstance(drawn, gx.Layer) else style
        found = gx.render_array(drawn, camera=camera, size=(120, 90), **own)  # type: ignore[arg-type]
        expected = gx.render_array(mesh, camera=camera, size=(120, 90), **style)  # type: ignore[arg-type]
        assert np.abs(found.astype(int) - expected).max() <= 3
        assert len(np.unique(expected)) > 2
    at_first = gx.render_array(before, camera=made.camera, size=(120, 90), color="red")
    assert np.abs(np.asarray(made[0]).astype(int) - at_first).max() <= 3  # an animation keeps what it was made of


@pytest.mark.usefixtures("device")
def test_frames_that_stay_on_the_device_are_the_same_frames() -> None:
    host, device = make_cloth(12, pinned=[0, 11]), make_cloth(12, pinned=[0, 11])
    expected, kept = host.simulate(0.3, 20.0, drag=1.0), device.simulate(0.3, 20.0, drag=1.0, keep="device")
    models = kept.as_models()
    assert all(isinstance(model, gx.MeshBuffer) for model in models)
    assert kept.shape == expected.shape
    assert kept.fps == expected.fps == pytest.approx(20.0)
    np.testing.assert_array_equal(kept[2], expected[2])
    np.testing.assert_array_equal(np.stack(list(kept[1:3])), expected.positions[1:3])
    np.testing.assert_array_equal(kept.positions, expected.positions)
    np.testing.assert_array_equal(kept.meshes()[3].positions, expected.meshes()[3].positions)
    drawn = gx.animate(device, kept, size=(100, 80), hidden="remove")
    assert drawn.fps == pytest.approx(20.0)
    same = gx.animate(host.mesh, expected.meshes(), size=(100, 80), hidden="remove", camera=drawn.camera)
    assert np.abs(np.asarray(drawn[4]).astype(int) - np.asarray(same[4])).max() <= 3
    with pytest.raises(gx.ArgumentError, match=r"^keep must be 'host' or 'device', got 'gpu'$"):
        host.simulate(0.1, keep="gpu")  # type: ignore[arg-type]


def test_a_frame_on_the_device_that_is_not_finite_is_named() -> None:
    springs = pair(mass=[1.0, 1e-30], stiffness=0.0)
    with pytest.raises(
        gx.SimulationError, match=r"^point \d is not at a finite position in frame 1, at 1 s: "
    ) as error:
        springs.simulate(3.0, 1.0, force=lambda *_: np.full((2, 3), 1e30), keep="device")
    assert error.value.frame == 1
    assert springs.trajectory is not None
    assert len(springs.trajectory) == 1


@pytest.mark.parametrize("n", [6, 40])  # any springs, a grid
def test_a_point_that_is_held_goes_where_it_is_moved_and_takes_the_rest_along(n: int) -> None:
    springs, free = make_cloth(n, damping=1e-4), make_cloth(n, damping=1e-4)
    point = n * n // 2
    start = springs.positions[point].astype(float)
    there = start + np.array([0.0, 0.02, 0.01])
    springs.hold(point)
    springs.simulate(0.1, 20.0)
    np.testing.assert_array_equal(springs.positions[point], start.astype(np.float32))
    np.testing.assert_array_equal(springs.velocities[point], 0.0)
    assert springs.positions[:, 1].min() < start[1] - 0.01
    springs.hold(point, there)
    springs.simulate(0.05, 20.0)
    np.testing.assert_allclose(springs.positions[point], there, atol=1e-5)
    np.testing.assert_allclose(springs.velocities[point], (0.0, 0.4, 0.2), rtol=1e-5)
    springs.simulate(0.05, 20.0)  # it arrived, and rests
    np.testing.assert_allclose(springs.positions[point], there, atol=1e-6)
    held = springs.state()
    springs.release(point)
    springs.simulate(0.2, 20.0)
    assert springs.positions[point, 1] < start[1]
    free.restore(held)  # a state holds no point
    free.simulate(0.2, 20.0)
    np.testing.assert_array_equal(free.positions, springs.positions)


def test_a_pinned_point_that_is_held_stays_where_it_is_released() -> None:
    springs = make_cloth(6, pinned=[0, 5])
    there = springs.positions[5].astype(float) + np.array([0.01, 0.02, 0.0])
    springs.hold(5, there)
    springs.simulate(0.05, 20.0)
    springs.release()
    springs.simulate(0.1, 20.0)
    np.testing.assert_allclose(springs.positions[5], there, atol=1e-6)
    springs.hold(4)
    springs.reset()
    springs.simulate(0.1, 20.0)
    assert springs.positions[4, 1] < 0.0
    with pytest.raises(gx.ArgumentError, match=r"^point must lie in 0..35, got 36$"):
        springs.hold(36)
    with pytest.raises(gx.ArgumentError, match=r"^position must be"):
        springs.hold(3, (0.0, NAN, 0.0))


@pytest.mark.usefixtures("device")
def test_a_drag_does_not_grow_memory() -> None:
    springs = make_cloth(40, damping=1e-4)
    context = springs.device.context  # type: ignore[attr-defined]  # of a graphics adapter

    def drag(n: int) -> None:
        for k in range(n):
            springs.hold(3 * k, springs.positions[3 * k] + (0.0, 0.0, 0.001))
            springs.step(2)
            springs.buffer().bounds()
            springs.release()

    drag(3)
    before = count_bytes(context)
    drag(20)
    assert count_bytes(context) == before


def test_pins_and_obstacles_follow_a_node_of_a_scene() -> None:
    scene = gx.Scene()
    scene.add(name="arm", transform=gx.rotate_y(0.3))
    scene.add(name="hand", parent="arm", transform=gx.translate(0.5, 0.0, 0.0))
    rest = gx.samples.cloth(8, 8)
    keys = {"translation": np.array([[0.5, 0, 0], [0.5, 0.2, 0.3]])}
    channel = Channel("hand", "translation", np.array([0.0, 0.5]), keys["translation"])
    turn = SceneAnimation("wave", (channel,), {"hand": Placement(np.zeros(3), np.array([0.0, 0, 0, 1]), np.ones(3))})
    follow = scene.follow("hand", turn)
    cloth = gx.Springs(rest, mass=0.1, stretch=100.0, pinned=[0, 8], damping=1e-3)
    ball = gx.Sphere((0.0, -0.3, 0.0), 0.1, gap=0.01, transform=follow)
    path = cloth.simulate(0.5, 20.0, move_pins=follow, obstacles=ball)
    moved = gx.rotate_y(0.3)[:3, :3] @ (0.0, 0.2, 0.3)
    np.testing.assert_allclose(path[-1][[0, 8]], rest.positions[[0, 8]] + moved, atol=1e-5)
    assert np.linalg.norm(path[-1] - (np.array([0.0, -0.3, 0.0]) + moved), axis=1).min() > 0.1


@pytest.mark.usefixtures("device")
def test_springs_on_the_host_device_are_drawn_as_well() -> None:
    host = gx.Device("host")
    there = gx.Springs(cloth_mesh(8), mass=0.2, stretch=1000.0, pinned=[0, 7], device=host)
    path = there.simulate(0.2, 20.0, keep="device")
    assert all(isinstance(model, gx.Mesh) for model in path.as_models())
    drawn = gx.animate(there, path, size=(60, 40), hidden="remove")
    expected = gx.render_array(path.meshes()[2], size=(60, 40), hidden="remove", camera=drawn.camera)
    np.testing.assert_array_equal(np.asarray(drawn[2]), expected)
    there.hold(20, (0.3, 0.1, 0.3))
    there.simulate(0.05, 20.0)
    np.testing.assert_allclose(there.positions[20], (0.3, 0.1, 0.3), atol=1e-5)
    assert np.array_equal(
        gx.render_array(there, size=(60, 40), camera=drawn.camera),
        gx.render_array(there.mesh, size=(60, 40), camera=drawn.camera),
    )


def test_keywords_of_steps_that_do_not_exist_are_errors() -> None:
    with pytest.raises(
        gx.ArgumentTypeError, match=r"^unexpected keyword argument 'gravitty'; did you mean 'gravity'\?$"
    ):
        pair().step(gravitty=1)  # type: ignore[call-arg]
    with pytest.raises(gx.ArgumentTypeError, match=r"^unexpected keyword argument 'frames'$"):
        pair().count_substeps(frames=1)  # type: ignore[call-arg]


def test_rounding_that_changes_lengths_is_a_warning() -> None:
    with pytest.warns(
        gx.SimulationWarning, match=r"changes the distance of points 0 and 1 by 25 %, as they are far"
    ) as seen:
        pair(model=[[1e6, 0, 0], [1e6 + 0.1, 0, 0]])
    assert seen[0].filename == __file__


def test_only_springs_are_joined() -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"^parts must be a sequence of Springs, got Springs$"):
        gx.Springs.join(pair())  # type: ignore[arg-type]
    with pytest.raises(gx.ArgumentTypeError, match=r"^parts must hold Springs, got Mesh$"):
        gx.Springs.join([pair(), SQUARE])  # type: ignore[list-item]


def test_a_point_that_is_not_there_is_not_released() -> None:
    with pytest.raises(gx.ArgumentError, match=r"^point must lie in 0..1, got 2$"):
        pair().release(2)


def test_a_damaged_state_is_an_error() -> None:
    springs = pair()
    state = springs.state()
    with pytest.raises(gx.ArgumentError, match=r"^state must be what Springs.state\(\) returned, got "):
        springs.restore(memoryview(state)[::2])
    n_refused = 0
    for at in range(len(state) - 700, len(state)):  # the directory of the archive
        damaged = bytearray(state)
        damaged[at] ^= 0x55
        try:
            springs.restore(damaged)
        except gx.ArgumentError:
            n_refused += 1
    assert n_refused > 100


def test_two_threads_take_turns() -> None:
    alone, shared = make_cloth(4, pinned=[0]), make_cloth(4, pinned=[0])
    other = threading.Thread(target=lambda: shared.simulate(0.2))

    def push(time: float, positions: Any, _: Any) -> npt.NDArray[np.float32]:
        if time == 0.0 and other.ident is None:
            other.start()
            other.join(0.1)  # it waits for the end of the run
        return np.zeros_like(positions)

    first = shared.simulate(0.2, force=push)
    other.join()
    assert np.array_equal(first, alone.simulate(0.2))
    assert np.array_equal(shared.positions, alone.simulate(0.2)[-1])
    assert shared.time == alone.time


@pytest.mark.parametrize("name", ["simulate", "step", "reset"])
def test_a_run_within_a_run_is_an_error(name: str) -> None:
    springs = pair()
    with pytest.raises(gx.SimulationError, match=r"^simulate, step, restore and reset cannot be called while"):
        springs.simulate(0.1, progress=lambda *_: getattr(springs, name)(*([0.1] if name == "simulate" else [])))
    springs.simulate(0.1)


def test_a_copy_goes_on_by_itself() -> None:
    springs = make_cloth(3, pinned=[0])
    springs.simulate(0.1)
    copies = [copy.copy(springs), copy.deepcopy(springs), pickle.loads(pickle.dumps(springs))]  # noqa: S301  # of its own bytes
    path = springs.simulate(0.1)
    for other in copies:
        assert other.device is springs.device or other.device.name == springs.device.name == "host"
        assert other.time == pytest.approx(0.1)
        assert np.array_equal(other.simulate(0.1), path)


def test_frames_on_the_device_are_not_pickled(device: Any) -> None:
    path = pair(device=device).simulate(0.1, keep="device")
    for value in (path, path.as_models()[0], device):
        with pytest.raises(
            gx.ArgumentTypeError,
            match=r"^the device '.*', and what is on it, cannot be copied or pickled(\nwhen serializing|$)",
        ):
            pickle.dumps(value)


def test_a_reversed_trajectory_has_the_same_frame_rate() -> None:
    assert pair().simulate(0.2)[::-1].fps == pytest.approx(30.0)


def test_another_thread_sees_no_frame_that_is_half_done(monkeypatch: pytest.MonkeyPatch) -> None:
    springs, alone = make_cloth(4, pinned=[0]), make_cloth(4, pinned=[0])
    seen: list[npt.NDArray[np.float32]] = []
    viewer = threading.Thread(target=lambda: seen.append(springs.velocities))
    take_steps = springs._stepper.step

    def step(*arguments: Any) -> None:
        if viewer.ident is None:
            viewer.start()
            viewer.join(0.1)
            assert not seen
        take_steps(*arguments)

    monkeypatch.setattr(springs._stepper, "step", step)
    path = springs.simulate(0.1)
    viewer.join()
    assert np.array_equal(path, alone.simulate(0.1))
    assert np.isfinite(seen[0]).all()
