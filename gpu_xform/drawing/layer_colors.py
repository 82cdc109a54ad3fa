"""The colours of a layer's lines and faces, from its style."""

from collections.abc import Sequence
from numbers import Real
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..imaging.colormaps import apply_colormap
from ..imaging.colors import COLOR_CYCLE, Rgba, pack_rgba8, to_rgba, to_rgba_array
from .enums import ColorMode
from .layer import Layer

PackedColors: TypeAlias = npt.NDArray[np.uint32]

BLACK: Rgba = (0.0, 0.0, 0.0, 1.0)
NO_COLORS: PackedColors = np.empty(0, np.uint32)
OPAQUE = np.uint32(0xFF000000)  # and any colour, packed


class LineColors(NamedTuple):
    """The colours of lines: `uniform` if the mode is that, else `packed`, one per edge or one per vertex.

    key : under which a device keeps them; None for colours that the caller gave
    """

    mode: ColorMode
    uniform: Rgba
    packed: PackedColors
    key: str | None = None

    @property
    def has_transparency(self) -> bool:
        """Whether some of the packed colours are not opaque."""
        return bool((self.packed < OPAQUE).any())


def colors_by_face(layer: Layer) -> bool:
    """Say whether the edges of each face have their own colour."""
    others = (layer.edge_colors, layer.vertex_colors, layer.scalars)
    return layer.face_colors is not None or (_is_color_cycle(layer.color) and all(colors is None for colors in others))


def has_several_colors(layer: Layer) -> bool:
    """Say whether the lines of a layer may differ in colour."""
    others = (layer.edge_colors, layer.vertex_colors, layer.scalars)
    return colors_by_face(layer) or any(colors is not None for colors in others)


def line_colors(layer: Layer, n_points: int, n_faces: int, n_edges: int) -> LineColors:
    """Return the colours that `layer` asks for; one per face if `colors_by_face`.

    n_edges : rows that edge_colors must have
    """
    if layer.face_colors is not None:
        return LineColors(
            ColorMode.PER_EDGE, BLACK, pack_rgba8(to_rgba_array(layer.face_colors, "face_colors", n_faces, "faces"))
        )
    if layer.edge_colors is not None:
        return LineColors(
            ColorMode.PER_EDGE, BLACK, pack_rgba8(to_rgba_array(layer.edge_colors, "edge_colors", n_edges, "edges"))
        )
    if layer.vertex_colors is not None:
        return LineColors(
            ColorMode.PER_VERTEX,
            BLACK,
            pack_rgba8(to_rgba_array(layer.vertex_colors, "vertex_colors", n_points, "points")),
        )
    if layer.scalars is not None:
        return LineColors(
            ColorMode.PER_VERTEX, BLACK, pack_rgba8(apply_colormap(layer.scalars, layer.cmap, layer.clim, n_points))
        )
    if _is_color_cycle(layer.color):
        return LineColors(
            ColorMode.PER_EDGE, BLACK, pack_rgba8(_parse_cycle("color"))[np.arange(n_faces) % len(COLOR_CYCLE)], "cycle"
        )
    return LineColors(ColorMode.UNIFORM, to_rgba(layer.color, "color"), NO_COLORS)


def fill_colors(layer: Layer, n_faces: int) -> npt.NDArray[np.float64]:
    """Return the colours of `layer.fill`: (n_faces, 4), or (1, 4) if all faces have one."""
    fill = layer.fill
    if _is_color_cycle(fill):
        return _parse_cycle("fill")[np.arange(n_faces) % len(COLOR_CYCLE)]
    if _is_single_color(fill):
        return np.array([to_rgba(fill, "fill")])
    return to_rgba_array(fill, "fill", n_faces, "faces")


def _is_single_color(color: object) -> bool:
    """Say whether `color` is one, not several: a name, or a sequence whose last item is a number."""
    if isinstance(color, Sequence | np.ndarray) and not isinstance(color, str):
        is_empty = color.size == 0 or color.ndim == 0 if isinstance(color, np.ndarray) else len(color) == 0
        return not is_empty and isinstance(color[-1], Real)
    return isinstance(color, str)


def _is_color_cycle(color: object) -> bool:
    return isinstance(color, str) and color == "face"


def _parse_cycle(name: str) -> npt.NDArray[np.float64]:
    return np.array([to_rgba(color, name) for color in COLOR_CYCLE])
