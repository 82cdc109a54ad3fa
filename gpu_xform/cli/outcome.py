"""Outcome of a picture: what became of it, in words, numbers and small pictures, for messages and reports."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from .outputs import PlannedPicture

if TYPE_CHECKING:
    from PIL.Image import Image

# Ordered as reports list them: what asks for attention first.
Status = Literal["failed", "differs", "no reference", "updated", "added", "matched", "drawn"]


class DifferenceNumbers(NamedTuple):
    """How a picture differs from its reference, of 255; the fields are those of `Difference`.

    n_allowed : of pixels that may differ by more than the threshold
    """

    n_pixels: int
    n_allowed: int
    largest: int
    largest_at: tuple[int, int]
    mean: float


@dataclass
class Outcome:
    """What became of a planned picture.

    message : why it failed, without the name of the command
    exit_code : 0 if it is done
    time_s : seconds to read, draw, write and compare
    images : what there is of "picture", "reference" and "difference": a Pillow image, or the text of an SVG
    embedded : data URIs of `images`, which take less memory
    """

    picture: PlannedPicture
    status: Status = "failed"
    message: str = ""
    exit_code: int = 0
    numbers: DifferenceNumbers | None = None
    time_s: float = 0.0
    images: "dict[str, Image | str]" = field(default_factory=dict[str, Any])
    embedded: dict[str, str] = field(default_factory=dict[str, str])

    @property
    def is_good(self) -> bool:
        """Whether the picture is as it should be."""
        return self.exit_code == 0
