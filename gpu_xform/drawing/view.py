"""What all that is drawn in a picture shares."""

from dataclasses import dataclass


@dataclass(frozen=True)
class View:
    """What all shapes of a picture share.

    size : pixels
    pixel_depth : (x, y); over a pixel's width along the view, the depth d changes by x * d + y
    """

    size: tuple[int, int]
    pixel_depth: tuple[float, float]
