"""What a model does: how many frames there are, and what each of them is."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .._core.arguments import as_float, as_int, as_square_matrices
from .._core.types import MatrixLike, SupportsAsMatrix
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.scene import Scene
from .poses import Frame, Pose, checked_pose

Frames: TypeAlias = MatrixLike | Iterable[Frame] | Callable[[int], Frame] | Callable[[float], Frame]

SLOWEST_FPS, FASTEST_FPS = 0.01, 1000.0
MOST_FRAMES = 2**31 - 1  # as far as an animated PNG can count


@dataclass(frozen=True)
class Motion:
    """So many poses of a model, each found by its frame's number, and how many a second are shown."""

    n_frames: int
    fps: float
    at: Callable[[int], Pose]


def described(frames: Frames, fps: float, n_frames: int | None, duration: float | None) -> Motion:
    """Return the motion that the arguments of `animate` with these names describe. Raises as it does."""
    fps = as_float(fps, "fps")
    if not SLOWEST_FPS <= fps <= FASTEST_FPS:
        raise ArgumentError.expecting("fps", f"lie in [{SLOWEST_FPS:g}, {FASTEST_FPS:g}]", f"{fps:g}")
    if callable(frames):
        return _computed(frames, fps, n_frames, duration)
    if n_frames is not None or duration is not None:
        raise ArgumentError("n_frames and duration go with a function: frames that are given are counted")
    poses = [checked_pose(frame, f"frames[{k}]") for k, frame in enumerate(_listed(frames))]
    if not poses:
        raise ArgumentError.expecting("frames", "hold at least one", "none")
    return Motion(len(poses), fps, poses.__getitem__)


def frame_count(n_frames: int, name: str) -> int:
    """Return a number of frames as an int."""
    count = as_int(n_frames, name)
    if count < 1:
        raise ArgumentError.expecting(name, "be at least 1", count)
    if count > MOST_FRAMES:
        raise ArgumentError.expecting(name, f"be at most {MOST_FRAMES}", count)
    return count


def _computed(function: Callable[[Any], Any], fps: float, n_frames: int | None, duration: float | None) -> Motion:
    """Return the motion that a function of the frame's number gives, or of its time where a duration is given."""
    if (n_frames is None) == (duration is None):
        raise ArgumentError(
            "frames is a function: either n_frames must say for how many numbers, from 0, or duration for how many "
            f"seconds, got {'neither' if n_frames is None else 'both'}"
        )
    if n_frames is None:
        seconds = as_float(duration, "duration")  # type: ignore[arg-type]  # one of the two is given
        if seconds <= 0.0:
            raise ArgumentError.expecting("duration", "be positive", f"{seconds:g}")
        if seconds > MOST_FRAMES / fps:
            longest = f"{MOST_FRAMES / fps:g} seconds at {fps:g} frames a second"
            raise ArgumentError.expecting("duration", f"be at most {longest}", f"{seconds:g}")
        n_frames = max(1, round(seconds * fps))
    step = 1 if duration is None else 1 / fps

    def at(k: int) -> Pose:
        try:
            frame = function(k * step)
        except Exception as error:
            what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
            raise ArgumentError(f"frames raised at frame {k}: {what}") from error
        return checked_pose(frame, f"frames({k * step:g})")

    return Motion(frame_count(n_frames, "n_frames"), fps, at)


def _listed(frames: Any) -> Iterable[Any]:
    """Return the frames one by one; a stack of matrices is taken apart."""
    if isinstance(frames, SupportsAsMatrix):
        frames = as_square_matrices(frames, "frames", 4)
    if isinstance(frames, np.ndarray) and (frames.ndim != 3 or frames.shape[1:] != (4, 4)):
        raise ArgumentError.expecting("frames", "have shape (k, 4, 4)", frames.shape)
    if isinstance(frames, str | bytes | Mapping | Scene) or not isinstance(frames, Iterable):
        raise ArgumentTypeError.expecting(
            "frames", "be matrices, one a frame, or a function that gives them", type(frames).__name__
        )
    return frames
