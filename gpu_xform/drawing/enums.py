"""Enumerations of how lines are drawn: hidden-line styles, dashes and colour modes.

They are the one source of their words and numbers: the command line, the viewer and `Layer` take the words from here,
and the WGSL constants `HIDDEN_*`, `DASHES_*` and `COLOR_*` are held to the members by a test.
"""

from enum import IntEnum
from typing import Literal, TypeAlias, get_args

HiddenStyle: TypeAlias = Literal["show", "remove", "dash", "fade"]
HIDDEN_STYLES: tuple[HiddenStyle, ...] = get_args(HiddenStyle)


Shading: TypeAlias = Literal["none", "flat", "smooth"]
SHADE = "shade"  # a fill, which is shaded
SHADINGS: tuple[Shading, ...] = get_args(Shading)


HIDDEN_FADE_ALPHA = 0.25  # what hidden parts keep of their opacity if they fade; as in the shaders


class Hidden(IntEnum):
    """How the parts of lines behind faces are drawn: `HiddenStyle` as the numbers of the WGSL constants `HIDDEN_*`.

    ONLY draws nothing but these parts: hidden lines of a style of their own.
    """

    SHOW = 0
    REMOVE = 1
    DASH = 2
    FADE = 3
    ONLY = 4

    @classmethod
    def from_style(cls, style: HiddenStyle) -> "Hidden":
        """Return the member that a style names."""
        return cls[style.upper()]


class Dashes(IntEnum):
    """How lines are dashed: not at all, by one dash of a pixel or more and one gap, or by any pattern."""

    NONE = 0
    SIMPLE = 1
    COMPOUND = 2


class ColorMode(IntEnum):
    """What each colour of lines belongs to; the numbers are the WGSL constants `COLOR_*`."""

    UNIFORM = 0
    PER_EDGE = 1
    PER_VERTEX = 2
