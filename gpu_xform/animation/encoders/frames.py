"""Frame sequence: the pictures that an encoder is given, and how long each is shown."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from ...errors import ArgumentError
from ...imaging.image import Pixels

# Browsers take a delay of a hundredth of a second or less for a mistake, and make it ten. At this rate, delays in whole
# milliseconds are 11 or 12.
MAX_BROWSER_FPS = 90


@dataclass(frozen=True)
class FrameSequence:
    """Pictures (height, width, 4), drawn when they are requested.

    frames : all of them in order, to be iterated over once
    sample : draws a few of them, by their indices, before the first is requested
    is_opaque : whether all pixels of all frames are opaque
    title : what they show; may be empty
    """

    size: tuple[int, int]
    n_frames: int
    fps: float
    frames: Iterator[Pixels]
    sample: Callable[[Sequence[int]], Iterator[Pixels]]
    is_opaque: bool
    title: str = ""

    def durations(self, unit_s: float) -> Sequence[int]:
        """Return for how many units of time each frame is shown; each begins within half a unit of its exact time."""
        starts = [round(k / (self.fps * unit_s)) for k in range(self.n_frames + 1)]
        return [end - start for start, end in pairwise(starts)]

    def require_rate_within(self, max_fps: int, format_name: str) -> None:
        """Raise `ArgumentError` if frames follow one another faster than programs show them in the format."""
        if self.fps > max_fps:
            raise ArgumentError.expecting("fps", f"be at most {max_fps} in {format_name}", f"{self.fps:g}")

    def require_size_within(self, max_side_px: int, format_name: str) -> None:
        """Raise `ArgumentError` if the pictures are larger than the format can store."""
        if max(self.size) > max_side_px:
            width, height = self.size
            limit = f"be at most {max_side_px} x {max_side_px} in {format_name}"
            raise ArgumentError.expecting("size", limit, f"{width} x {height}")
