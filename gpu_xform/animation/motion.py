"""Motion: the number of frames of an animation, their rate, and the pose of each."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from .._core.arguments import as_float, as_int, as_square_matrices
from .._core.types import MatrixLike, SupportsAsMatrix
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.scene import Scene
from ..geometry.scene_animation import SceneAnimation
from ..simulation.trajectory import Trajectory
from .poses import Pose, PoseLike, as_pose

PosesLike: TypeAlias = (
    MatrixLike
    | Iterable[PoseLike]
    | Callable[[int], PoseLike]
    | Callable[[float], PoseLike]
    | SceneAnimation
    | Trajectory
)

DEFAULT_FPS = 20.0
MIN_FPS, MAX_FPS = 0.01, 1000.0
MAX_FRAMES = 2**31 - 1  # as far as an animated PNG can count


@dataclass(frozen=True)
class Motion:
    """Poses of a model, found by the index of their frame, and how many are shown per second."""

    n_frames: int
    fps: float
    pose_at: Callable[[int], Pose]


def make_motion(frames: PosesLike, fps: float | None, n_frames: int | None, duration: float | None) -> Motion:
    """Return the motion that `animate`'s arguments of these names describe. Raises as `animate` does."""
    if fps is None:
        fps = (frames.fps if isinstance(frames, Trajectory) else None) or DEFAULT_FPS
    fps = as_float(fps, "fps")
    if not MIN_FPS <= fps <= MAX_FPS:
        raise ArgumentError.expecting("fps", f"lie in [{MIN_FPS:g}, {MAX_FPS:g}]", f"{fps:g}")
    if callable(frames):
        return _sample_function(frames, fps, n_frames, duration)
    if n_frames is not None or duration is not None:
        raise ArgumentError("n_frames and duration go with a function: frames that are given are counted")
    if isinstance(frames, SceneAnimation):
        return Motion(
            parse_frame_count(round(frames.duration * fps) + 1, "frames"), fps, partial(_pose_scene, frames, fps)
        )
    models = frames.as_models() if isinstance(frames, Trajectory) else frames
    if isinstance(models, np.ndarray) and models.ndim:
        parse_frame_count(max(len(models), 1), "frames")
    poses = [as_pose(frame, f"frames[{k}]") for k, frame in enumerate(_iterate(models))]
    if not poses:
        raise ArgumentError.expecting("frames", "hold at least one", "none")
    return Motion(len(poses), fps, poses.__getitem__)


def parse_frame_count(n_frames: int, name: str) -> int:
    """Return a number of frames as an int."""
    count = as_int(n_frames, name)
    if count < 1:
        raise ArgumentError.expecting(name, "be at least 1", count)
    if count > MAX_FRAMES:
        raise ArgumentError.expecting(name, f"be at most {MAX_FRAMES}", count)
    return count


def _sample_function(
    function: Callable[[Any], Any], fps: float, n_frames: int | None, duration: float | None
) -> Motion:
    """Return the motion that a function of the frame's index gives, or of its time if a duration is given."""
    if (n_frames is None) == (duration is None):
        raise ArgumentError(
            "frames is a function: either n_frames (the number of calls) or duration (in seconds) must be given, "
            f"got {'neither' if n_frames is None else 'both'}"
        )
    if n_frames is None:
        seconds = as_float(duration, "duration")  # type: ignore[arg-type]  # one of the two is given
        if seconds <= 0.0:
            raise ArgumentError.expecting("duration", "be positive", f"{seconds:g}")
        if seconds > MAX_FRAMES / fps:
            limit = f"be at most {MAX_FRAMES / fps:g} seconds at {fps:g} frames per second"
            raise ArgumentError.expecting("duration", limit, f"{seconds:g}")
        n_frames = max(1, round(seconds * fps))
    step = 1 if duration is None else 1 / fps
    return Motion(parse_frame_count(n_frames, "n_frames"), fps, partial(_call, function, step))


def _pose_scene(frames: SceneAnimation, fps: float, k: int) -> Pose:
    return frames.at(k / fps)


def _call(function: Callable[[Any], Any], step: float, k: int) -> Pose:
    """Return what a function of the user gives for a frame."""
    try:
        frame = function(k * step)
    except Exception as error:
        what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise ArgumentError(f"frames raised at frame {k}: {what}") from error
    return as_pose(frame, f"frames({k * step:g})")


def choose_frames(motion: Motion, chosen: range) -> Motion:
    """Return the motion of some frames of another."""
    return Motion(len(chosen), motion.fps, partial(_choose_pose, motion.pose_at, chosen))


def _choose_pose(pose_at: Callable[[int], Pose], chosen: range, k: int) -> Pose:
    return pose_at(chosen[k])


def _iterate(frames: Any) -> Iterable[Any]:
    """Return the frames one by one; a stack of matrices is split."""
    if isinstance(frames, SupportsAsMatrix):
        frames = as_square_matrices(frames, "frames", 4)
    if isinstance(frames, np.ndarray) and (frames.ndim != 3 or frames.shape[1:] != (4, 4)):
        raise ArgumentError.expecting("frames", "have shape (k, 4, 4)", frames.shape)
    if isinstance(frames, str | bytes | Mapping | Scene) or not isinstance(frames, Iterable):
        raise ArgumentTypeError.expecting(
            "frames", "be matrices, one per frame, or a function that returns them", type(frames).__name__
        )
    return frames
