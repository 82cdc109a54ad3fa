"""The keys of a picture: what legends and colour bars say of its layers."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..annotation.column import ColorBar, LegendEntry
from ..annotation.options import LegendLike
from ..compute.mesh_buffer import MeshBuffer
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.mesh import Mesh
from ..imaging.colormaps import apply_colormap, tabulate_colormap
from ..imaging.colors import Rgba, to_rgba
from .build_layer import CLOUD_POINT_SIZE_PX
from .cloud_source import CloudSource, Source
from .intersections import IntersectionLayer
from .layer import Layer
from .layer_colors import LineColors, fill_colors, line_colors

_N_COLORS = 256  # of a colour bar whose colormap is a callable


def legend_entries(layers: Sequence[Layer], sources: Sequence[Source], legend: LegendLike) -> list[LegendEntry]:
    """Return the entries of a legend: of the layers that have names, or that are given texts.

    Raises `ArgumentError` if there are none, if all look alike, or if there are not as many texts as layers.
    """
    if legend is False:
        return []
    if legend is True:
        own = [not isinstance(layer, IntersectionLayer) for layer in layers]
        names: Sequence[str | None] = [
            source.name if is_own else None for source, is_own in zip(sources, own, strict=True)
        ]
        if not any(names):
            raise ArgumentError.expecting("legend", "come with models that have names, or be a text per model", "none")
    else:
        given = [i for i, layer in enumerate(layers) if not isinstance(layer, IntersectionLayer)]
        if len(legend) != len(given):
            raise ArgumentError.expecting("legend", f"have one text for each of the {len(given)} models", len(legend))
        texts = dict(zip(given, legend, strict=True))
        names = [texts.get(i) for i in range(len(layers))]
    entries = [
        _describe(layer, source, name)
        for layer, source, name in zip(layers, sources, names, strict=True)
        if name and name.strip()
    ]
    if len(entries) > 1 and len({replace(entry, name="") for entry in entries}) == 1:
        reason = f"all {len(entries)} look alike: give each a color or a fill of its own"
        raise ArgumentError.expecting("legend", "tell the models apart", reason=reason)
    return entries


def color_bars(layers: Sequence[Layer]) -> list[ColorBar]:
    """Return a colour bar for each title, limits and colormap that layers ask for."""
    bars: dict[tuple[Any, ...], ColorBar] = {}
    for layer in layers:
        if layer.colorbar is False:
            continue
        title = layer.colorbar if isinstance(layer.colorbar, str) else ""
        limits = layer.scalar_limits()
        cmap = layer.cmap
        key = title, limits, cmap if isinstance(cmap, str) else id(cmap)
        if key not in bars:
            bars[key] = ColorBar(title, limits, _tabulate(cmap))
    return list(bars.values())


def check_legend(legend: Any) -> LegendLike:
    """Return a legend as a flag or a tuple of texts; raise `ArgumentTypeError` for anything else."""
    if isinstance(legend, bool | np.bool_):
        return bool(legend)
    return _check_texts(legend, "legend", "be True, False or a text per model")


def check_titles(axes: Any) -> tuple[str | None, ...] | None:
    """Return the titles of the three axes; None for no axes. Raises an error for anything else."""
    if axes is None or isinstance(axes, bool | np.bool_):
        return ("x", "y", "z") if axes else None
    titles = _check_texts(axes, "axes", "be True, False or three titles")
    if len(titles) != 3:
        raise ArgumentError.expecting("axes", "have three titles", len(titles))
    return titles


def _check_texts(texts: Any, name: str, expected: str) -> tuple[str | None, ...]:
    if isinstance(texts, str) or not isinstance(texts, Sequence):
        raise ArgumentTypeError.expecting(name, expected, repr(texts))
    for i, text in enumerate(texts):
        if text is not None and not isinstance(text, str):
            raise ArgumentTypeError.expecting(f"{name}[{i}]", "be a text", repr(text))
    return tuple(texts)


def _tabulate(cmap: Any) -> Float64Array:
    table = tabulate_colormap(cmap)
    return apply_colormap(np.linspace(0.0, 1.0, _N_COLORS), cmap, (0.0, 1.0), _N_COLORS) if table is None else table


def _describe(layer: Layer, source: Source, name: str) -> LegendEntry:
    has_lines = _has_lines(layer, source)
    line = _line_color(layer, source)
    dot_size = CLOUD_POINT_SIZE_PX if not has_lines and layer.fill is None else 0.0
    if layer.point_size is not None:
        dot_size = float(layer.point_size)  # in pixels by now
    width = layer.line_width if not isinstance(layer.line_width, str) else 1.5
    fill = None
    if layer.fill is not None:
        red, green, blue, alpha = fill_colors(layer, source.n_faces)[0].tolist()
        fill = red, green, blue, alpha * layer.alpha
    return LegendEntry(name, fill, line if has_lines else None, width, line if dot_size else None, dot_size)


def _has_lines(layer: Layer, source: Source) -> bool:
    if layer.edges is not None:
        return True
    model = layer.model
    if isinstance(source, CloudSource) or (isinstance(model, PointBuffer) and not isinstance(model, MeshBuffer)):
        return False
    mesh = model.topology if isinstance(model, MeshBuffer) else model
    return isinstance(mesh, Mesh) and len(mesh.offsets) > 1


def _line_color(layer: Layer, source: Source) -> Rgba:
    """Return the colour of the lines; of several colours the first, of numbers the middle one of the colormap."""
    if layer.scalars is not None:
        colors = apply_colormap(np.array([0.5]), layer.cmap, (0.0, 1.0), 1)
        red, green, blue, alpha = colors[0].tolist()
    elif layer.edge_colors is not None:
        colors = np.asarray(layer.edge_colors)[:1]
        red, green, blue, alpha = to_rgba(colors[0].tolist() if colors.dtype.kind == "f" else "gray", "edge_colors")
    else:
        found: LineColors = line_colors(layer, source.n_points, source.n_faces, 0)
        red, green, blue, alpha = found.uniform
        if len(found.packed):
            red, green, blue, alpha = (found.packed[:1].view(np.uint8) / 255.0).tolist()
    return red, green, blue, alpha * layer.alpha
