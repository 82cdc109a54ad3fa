"""What an encoder is given: pictures, one after another, and how long each is shown."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from ...errors import ArgumentError
from ...imaging.image import Pixels


@dataclass(frozen=True)
class Clip:
    """Pictures (height, width, 4), drawn as they are asked for.

    frames : all of them in their order, to be gone through once
    samples : draws a few of them, by their numbers, before the first is asked for
    is_opaque : whether no pixel of any lets through what is below
    """

    size: tuple[int, int]
    n_frames: int
    fps: float
    frames: Iterator[Pixels]
    samples: Callable[[Sequence[int]], Iterator[Pixels]]
    is_opaque: bool

    def durations(self, unit_s: float) -> Sequence[int]:
        """Return for how many units each frame is shown; each begins within half a unit of its time."""
        starts = [round(k / (self.fps * unit_s)) for k in range(self.n_frames + 1)]
        return [end - start for start, end in pairwise(starts)]

    def require_size_within(self, side: int, format_name: str) -> None:
        """Raise `ArgumentError` where the pictures are larger than the format can say."""
        if max(self.size) > side:
            width, height = self.size
            raise ArgumentError.expecting("size", f"be at most {side} x {side} in {format_name}", f"{width} x {height}")
