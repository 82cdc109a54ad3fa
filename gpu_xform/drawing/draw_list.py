"""The draw list: what a picture is made of on the device, whichever rasteriser draws it."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..gpu.buffers import Buffer
from ..gpu.device_points import DevicePoints
from .cloud_points import CloudPoints
from .dash_patterns import DashPattern
from .depth import NO_DEPTH_CUE, DepthCue
from .enums import ColorMode, Hidden
from .point_colors import PointColors

EDGE_BYTES = 8
NO_POINT = 2**32 - 1  # both ends of an edge that is not there
TRIANGLE_BYTES = 12


@dataclass(frozen=True)
class Faces:
    """Triangles that hide what is behind them, and that are filled if they have colours.

    triangles : (n_triangles, 3) uint32, indices of points
    color_indices : (n_triangles,) or (1,) uint32, the index of each triangle's colour in the palette of the draw list,
        counted from `first_color`; None for triangles that only hide
    is_opaque : all are filled, with opaque colours
    corner_normals : (n_triangles, 3) uint32, as `pack_normals` packs them, in the model's frame; None unless shading is
        smooth
    light_from_normals : (3, 3), from these to a frame whose third axis is towards the eye
    """

    triangles: Buffer
    n_triangles: int
    color_indices: Buffer | None = None
    first_color: int = 0
    depth_cue: DepthCue = NO_DEPTH_CUE
    is_opaque: bool = False
    corner_normals: Buffer | None = None
    light_from_normals: npt.NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Lines:
    """Edges, and how they are drawn.

    edges : (n_edges, 2) uint32, indices of points, or two `NO_POINT`
    line_width : pixels; None for aliased lines, which are one pixel wide
    color : straight alpha, used if colors is None
    colors : packed, (n_edges,) or one per point, as color_mode says
    opacity : of all of them, 0 to 1
    has_transparency : whether some of colors are not opaque
    are_points : the edges join points to themselves
    are_silhouettes : faces turn away from the eye along them, or may do so close beside them, as where bodies meet
    dash_px : lengths of dashes and gaps, in turn, of hidden parts if `hidden` is DASH, else of all that is drawn; empty
        for continuous lines
    chains : `layouts.CHAIN_EDGE` (n_edges,), along which dashes run on from edge to edge; None without dashes
    is_covered : only opaque filled faces hide these lines, those of `DrawList.covers`
    depth_cue : also orders lines of several colours by depth: nearer ones lie over farther ones
    """

    edges: Buffer
    n_edges: int
    line_width: float | None
    color: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    colors: Buffer | None = None
    color_mode: ColorMode = ColorMode.UNIFORM
    hidden: Hidden = Hidden.SHOW
    opacity: float = 1.0
    has_transparency: bool = False
    are_points: bool = False
    are_silhouettes: bool = False
    dash_px: DashPattern = ()
    chains: Buffer | None = None
    is_covered: bool = False
    depth_cue: DepthCue = NO_DEPTH_CUE


@dataclass(frozen=True)
class Drawable:
    """Points, drawn once per matrix, with the faces and lines that join them.

    clip_from_points : (k, 4, 4), reversed-Z: depth is 1 at the near plane and 0 at the far plane, so that single
        precision keeps apart what is far away
    """

    points: DevicePoints
    clip_from_points: npt.NDArray[np.float64]
    faces: Faces | None
    lines: tuple[Lines, ...]
    sample_edges: Callable[[], npt.NDArray[np.float64]] | None = None


@dataclass(frozen=True)
class Cloud:
    """Points that nothing joins, in dots, drawn once per matrix; nearer ones lie over farther ones.

    position : the number of drawables in the draw list that are drawn before it
    bounding_points : (h, 3), whose convex hull holds the offsets
    clip_from_points : (k, 4, 4), reversed-Z
    diameter : pixels
    scalar_row : (4,), times (offset, 1) the coordinate that goes through the colormap: 0 to 1 between its ends
    is_covered : as that of `Lines`
    """

    position: int
    points: CloudPoints
    colors: PointColors
    bounding_points: npt.NDArray[np.float64]
    clip_from_points: npt.NDArray[np.float64]
    diameter: float
    scalar_row: npt.NDArray[np.float64]
    hidden: Hidden
    opacity: float
    depth_cue: DepthCue
    is_covered: bool = False


@dataclass(frozen=True)
class DrawList:
    """All that a picture shows: filled faces first, then the lines of each drawable over those of the ones before.

    layer_indices : which layer each of the drawables comes from
    palette : (c,) packed, the colours of filled faces; c may be 0
    clouds : in the order in which they are drawn
    covers : the opaque filled faces once more, without colours; None if there are no others, or nothing is covered
    """

    drawables: list[Drawable]
    layer_indices: list[int]
    palette: npt.NDArray[np.uint32]
    clouds: list[Cloud] = field(default_factory=list)
    covers: list[Drawable] | None = None
