"""Colours as people write them, and the cycle that tells faces apart."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ._arguments import real_array
from .errors import ArgumentError

ColorLike = str | Sequence[float]
FloatColor = tuple[float, float, float, float]

# Ten hues that stay apart for most eyes: the category10 palette of Tableau, which matplotlib cycles through as well.
FACE_CYCLE = (
    "#1f77b4",
    "#ff7f0e",
    "#2ca02c",
    "#d62728",
    "#9467bd",
    "#8c564b",
    "#e377c2",
    "#7f7f7f",
    "#bcbd22",
    "#17becf",
)


def rgba(color: ColorLike, name: str) -> FloatColor:
    """Return red, green, blue and alpha in [0, 1], straight.

    color : a name or "#rgb", "#rrggbb", "#rrggbbaa", "rgb(...)", "hsl(...)" as Pillow has them; or three or four
        numbers in [0, 1]
    """
    if isinstance(color, str):
        from PIL import ImageColor

        try:
            red, green, blue, alpha = ImageColor.getcolor(color.strip(), "RGBA")  # type: ignore[misc]
        except ValueError:
            raise ArgumentError(f"{name} must be a colour's name or #rrggbb, got {color!r}") from None
        return red / 255, green / 255, blue / 255, alpha / 255
    components = real_array(color, name)
    if components.shape not in {(3,), (4,)} or (components < 0).any() or (components > 1).any():
        raise ArgumentError(f"{name} must be a colour's name, or three or four numbers from 0 to 1, got {color!r}")
    red, green, blue, *rest = components.tolist()
    return red, green, blue, rest[0] if rest else 1.0


def packed(colors: Sequence[FloatColor]) -> npt.NDArray[np.uint32]:
    """Return each colour as WGSL's `unpack4x8unorm` takes it, red in the lowest byte: (k,) uint32."""
    octets = np.rint(np.array(colors) * 255).astype(np.uint8)
    return np.ascontiguousarray(octets).view("<u4").reshape(-1)
