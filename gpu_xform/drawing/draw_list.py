"""What a picture is made of on the device: points with their instances, triangles that hide, and lines."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..gpu.buffers import Buffer
from ..gpu.device_points import DevicePoints
from .enums import ColorMode, Hidden

Cue: TypeAlias = tuple[float, float, float, float]

NO_CUE: Cue = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Faces:
    """Triangles that hide what is behind them, and that are painted where they have colours.

    triangles : (n_triangles, 3) uint32, indices of points
    color_places : (n_triangles,) or (1,) uint32, the place of each triangle's colour in the picture's palette, counted
        from `first_color`; None for triangles that only hide
    cue : what distance leaves of their colours, as in `Lines`
    """

    triangles: Buffer
    n_triangles: int
    color_places: Buffer | None = None
    first_color: int = 0
    cue: Cue = NO_CUE


@dataclass(frozen=True)
class Lines:
    """Edges, and how they are drawn.

    edges : (n_edges, 2) uint32, indices of points; two 2**32 - 1 for none
    line_width : pixels; None for lines one pixel wide, each pixel on or off
    color : straight alpha, where colors is None
    colors : packed, (n_edges,) or one a point, as color_mode says
    strength : of all of them, 0 to 1
    is_clear : whether some of colors let something shine through
    are_dots : the edges join points to themselves
    are_outlines : faces turn away from the eye along them
    cue : a place of depth d at distance w is clamp(x * d + y * w + z, 0, 1) of the way from the picture's nearest point
        to its farthest: nearer lines lie over farther ones; what it loses of its strength is w times that
    """

    edges: Buffer
    n_edges: int
    line_width: float | None
    color: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    colors: Buffer | None = None
    color_mode: ColorMode = ColorMode.UNIFORM
    hidden: Hidden = Hidden.SHOW
    strength: float = 1.0
    is_clear: bool = False
    are_dots: bool = False
    are_outlines: bool = False
    cue: Cue = NO_CUE


@dataclass(frozen=True)
class Shape:
    """Points as often as there are matrices, and what they carry.

    clip_from_points : (k, 4, 4), depth 1 at the near plane and 0 at the far one, so that single precision keeps apart
        what is far away
    """

    points: DevicePoints
    clip_from_points: npt.NDArray[np.float64]
    faces: Faces | None
    lines: tuple[Lines, ...]
