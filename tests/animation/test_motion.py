from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gpu_xform import Mesh, rotate_y, samples, save_mesh
from gpu_xform.animation.motion import Motion, make_motion
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from tests.support.reference_transform import AFFINE, PROJECTIVE

STACK = np.stack([AFFINE, PROJECTIVE, rotate_y(1)])


def of(frames: Any, fps: float = 20, n_frames: int | None = None, duration: float | None = None) -> Motion:
    return make_motion(frames, fps, n_frames, duration)


class Telling:
    """A function that keeps what it is called with."""

    def __init__(self) -> None:
        self.given: list[Any] = []

    def __call__(self, k: Any) -> Any:
        self.given.append(k)
        return AFFINE


def poses(motion: Motion) -> list[Any]:
    return [motion.pose_at(k) for k in range(motion.n_frames)]


@pytest.mark.parametrize(
    "frames",
    [STACK, list(STACK), tuple(STACK), iter(STACK), STACK.tolist(), STACK[::-1][::-1]],
    ids=["stack", "list", "tuple", "iterator", "nested lists", "view"],
)
def test_matrices_one_after_another(frames: Any) -> None:
    motion = of(frames)
    assert motion.n_frames == 3
    assert np.array_equal(poses(motion), STACK)


def test_what_has_matrices_is_taken_for_them() -> None:
    turns = Rotation.from_euler("y", [[10], [20], [70]], degrees=True)
    expected = np.tile(np.eye(4), (3, 1, 1))
    expected[:, :3, :3] = turns.as_matrix()
    assert np.array_equal(poses(of(turns)), expected)
    assert np.array_equal(poses(of([turns[0], turns[1], turns[2]])), expected)
    assert np.array_equal(poses(of(lambda k: turns[k], n_frames=3)), expected)


def test_a_function_gets_the_index_of_the_frame() -> None:
    motion = of(lambda k: STACK[k], n_frames=3)
    assert np.array_equal(poses(motion), STACK)
    told = Telling()
    poses(of(told, n_frames=4))
    assert told.given == [0, 1, 2, 3]
    assert {type(k) for k in told.given} == {int}


@pytest.mark.parametrize(
    ("seconds", "fps", "n_frames"), [(2.0, 20, 40), (0.5, 25, 12), (1e-3, 20, 1), (0.3, 10, 3), (1, 0.5, 1)]
)
def test_a_function_of_time_gets_seconds(seconds: float, fps: float, n_frames: int) -> None:
    told = Telling()
    motion = of(told, fps, duration=seconds)
    poses(motion)
    assert motion.n_frames == n_frames
    np.testing.assert_allclose(told.given, np.arange(n_frames) / fps, rtol=1e-15)


def test_a_function_is_called_when_its_frame_is_requested() -> None:
    told = Telling()
    of(told, n_frames=1000).pose_at(7)
    assert told.given == [7]


def test_models_are_frames_as_well(tmp_path: Any) -> None:
    cube, house = samples.cube(), samples.house()
    save_mesh(house, tmp_path / "house.obj")
    assert poses(of([cube, tmp_path / "house.obj", str(tmp_path / "house.obj")])) == [cube, house, house]
    assert poses(of(lambda k: (cube, house)[k], n_frames=2)) == [cube, house]


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ([], "frames must hold at least one, got none"),
        (np.empty((0, 4, 4)), "frames must hold at least one, got none"),
        (AFFINE, r"frames must have shape \(k, 4, 4\), got \(4, 4\)"),
        (np.zeros((2, 3, 3)), r"frames must have shape \(k, 4, 4\), got \(2, 3, 3\)"),
        (Rotation.identity(), r"frames must have shape \(k, 4, 4\), got \(4, 4\)"),
        ([AFFINE, np.eye(3)], r"frames\[1\] must have shape \(4, 4\), got \(3, 3\); homogeneous"),
        ([AFFINE, AFFINE * [1, 1, np.nan, 1]], r"frames\[1\] must be finite, got nan at index \(0, 2\)"),
        ([AFFINE, np.diag([1, -np.inf, 1, 1])], r"frames\[1\] must be finite, got -inf at index \(1, 1\)"),
    ],
)
def test_frames_that_are_none(frames: Any, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        of(frames)


@pytest.mark.parametrize("frames", ["cube.obj", b"x", 5, None, {"hand": AFFINE}, samples.cube()])
def test_frames_of_another_type(frames: Any) -> None:
    with pytest.raises(
        ArgumentTypeError, match="frames must be matrices, one per frame, or a function that returns them"
    ):
        of(frames)


@pytest.mark.parametrize("options", [{}, {"n_frames": 3, "duration": 1.0}])
def test_a_function_needs_one_length(options: dict[str, Any]) -> None:
    with pytest.raises(ArgumentError, match=r"either n_frames .* or duration .* got (neither|both)"):
        of(Telling(), **options)


@pytest.mark.parametrize("options", [{"n_frames": 3}, {"duration": 1.0}])
def test_frames_that_are_given_are_counted(options: dict[str, Any]) -> None:
    with pytest.raises(ArgumentError, match="n_frames and duration go with a function"):
        of(STACK, **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"n_frames": 0}, "n_frames must be at least 1, got 0"),
        ({"n_frames": 2.0}, "n_frames must be a whole number, got 2.0"),
        ({"duration": 0}, "duration must be positive, got 0"),
        ({"duration": -1.5}, "duration must be positive, got -1.5"),
        ({"duration": np.nan}, "duration must be finite, got nan"),
        ({"n_frames": 2**31}, "n_frames must be at most 2147483647, got 2147483648"),
        ({"n_frames": 2**63}, "n_frames must be at most 2147483647, got 9223372036854775808"),
        ({"duration": 1e30}, r"duration must be at most 1.07374e\+08 seconds at 20 frames per second, got 1e\+30"),
        ({"duration": 1e308, "fps": 1000}, r"duration must be at most .*, got 1e\+308"),
        ({"n_frames": 2, "fps": 0}, r"fps must lie in \[0.01, 1000\], got 0"),
        ({"n_frames": 2, "fps": np.inf}, "fps must be finite, got inf"),
        ({"n_frames": 2, "fps": 1001}, r"fps must lie in \[0.01, 1000\], got 1001"),
    ],
)
def test_lengths_and_rates_that_are_none(options: dict[str, Any], message: str) -> None:
    with pytest.raises((ArgumentError, ArgumentTypeError), match=message):
        of(Telling(), **options)


def test_a_function_that_raises_is_told_with_its_frame() -> None:
    def fall(k: int) -> Any:
        return [AFFINE][k]

    motion = of(fall, n_frames=3)
    motion.pose_at(0)
    with pytest.raises(
        ArgumentError, match=r"^frames raised at frame 2: IndexError: list index out of range$"
    ) as caught:
        motion.pose_at(2)
    assert isinstance(caught.value.__cause__, IndexError)


def test_what_stops_a_program_is_no_frame_s_fault() -> None:
    def stop(_: int) -> Any:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        of(stop, n_frames=1).pose_at(0)


@pytest.mark.parametrize(
    ("frame", "options", "message"),
    [
        (np.eye(3), {"n_frames": 9}, r"frames\(4\) must have shape \(4, 4\), got \(3, 3\)"),
        (np.full((4, 4), np.nan), {"duration": 9.0}, r"frames\(0.2\) must be finite, got nan"),
        (STACK, {"n_frames": 9}, r"frames\(4\) must have shape \(4, 4\), got \(3, 4, 4\)"),
        ([["a"]], {"n_frames": 9}, r"frames\(4\) must hold real numbers"),
        (None, {"n_frames": 9}, r"frames\(4\) must hold real numbers"),
    ],
)
def test_what_a_function_gives_is_checked(frame: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises((ArgumentError, ArgumentTypeError), match=message):
        of(lambda _: frame, **options).pose_at(4)


def test_a_mesh_is_kept_as_it_is() -> None:
    mesh = Mesh([(0, 0, 0), (1, 0, 0)], [(0, 1)])
    assert of([mesh]).pose_at(0) is mesh


def test_more_frames_than_there_may_be_are_refused_before_they_are_looked_at() -> None:
    stack = np.broadcast_to(np.eye(4), (1 << 40, 4, 4))
    with pytest.raises(ArgumentError, match=r"^frames must be at most \d+, got 1099511627776"):
        make_motion(stack, None, None, None)
