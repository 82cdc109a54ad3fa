"""SVG documents: one group per model, for browsers and drawing programs."""

import re
import unicodedata
import zlib
from collections.abc import Iterator, Sequence

import numpy as np

from .._core.types import BoolArray
from ..annotation.items import NO_ANNOTATION, Annotation
from ..drawing.lengths import MM_PER_INCH, PX_PER_INCH
from ..imaging.colors import Rgba
from .annotation_svg import escape_text, format_annotation
from .decimal_text import Bytes, format_rows, to_fixed_point
from .layer import FloatArray, Points, Stroke, VectorLayer
from .paths import (
    SEAM_WIDTH_PX,
    SMOOTH_SEAM_WIDTH_PX,
    Paths,
    make_line_paths,
    make_polygon_paths,
    quantize_colors,
    unique_colors,
)


def format_svg(
    size: tuple[float, float], background: Rgba, layers: Sequence[VectorLayer], annotation: Annotation = NO_ANNOTATION
) -> str:
    """Return an SVG document of `size` = (width, height) pixels that shows each layer over those before it.

    Sizes that are no integers are those of paper, and written in millimetres as well.
    Each model is a group. Its id is derived from the model's name, its title is the name, and it holds groups of class
    "faces", "hidden", "visible" and "points", as far as the model has such. Colours, widths and dashes are attributes
    of these groups, and of a path only if it differs. Coordinates are rounded to hundredths of a pixel. The annotation
    is a group "annotation" over all models.
    """
    width, height = (f"{side:.10g}" for side in size)
    is_paper = not all(isinstance(side, int) for side in size)
    shown = [f"{side * MM_PER_INCH / PX_PER_INCH:.10g}mm" for side in size] if is_paper else [width, height]
    box = f'viewBox="0 0 {width} {height}"'
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{shown[0]}" height="{shown[1]}" {box}>\n']
    if background[3] > 0.0:
        paint = _paint(quantize_colors(np.array([background]), 1)[0], "fill")
        parts.append(f'<rect id="background" width="{width}" height="{height}"{paint}/>\n')
    names = [layer.name for layer in layers]
    for layer, identifier in zip(layers, _identifiers(names), strict=True):
        parts.append(f'<g id="{identifier}">\n')
        if layer.name:
            parts.append(f"<title>{escape_text(layer.name)}</title>\n")
        parts.extend(_format_model(layer))
        parts.append("</g>\n")
    parts.extend(format_annotation(annotation))
    parts.append("</svg>\n")
    return "".join(parts)


def _identifiers(names: Sequence[str]) -> Iterator[str]:
    """Yield a unique id for each name: its ASCII letters and digits, and a number if another model has that id."""
    used, counts = {"background", "annotation", "annotation-text"}, dict[str, int]()
    for name in names:
        plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
        base = re.sub(r"[^A-Za-z0-9_]+", "-", plain).strip("-")
        if not base[:1].isalpha():
            base = f"model-{base}".rstrip("-")
        identifier = base
        while identifier in used:
            counts[base] = counts.get(base, 1) + 1
            identifier = f"{base}-{counts[base]}"
        used.add(identifier)
        yield identifier


def _format_model(layer: VectorLayer) -> Iterator[str]:
    if layer.polygons is not None:
        for alpha, paths in make_polygon_paths(layer.polygons):
            yield from _format_faces(paths, alpha)
    for name, hidden in (("hidden", True), ("visible", False)):
        stroke = _format_stroke(layer.stroke(hidden=hidden))
        yield from _format_lines(name, make_line_paths(layer, hidden=hidden), stroke)
    if layer.points is not None:
        yield from _format_points(layer.points)


def _format_stroke(stroke: Stroke) -> str:
    width = f' stroke-width="{_to_text(stroke.line_width)}"'
    if not stroke.dash:
        return f'{width} stroke-linecap="round" stroke-linejoin="round"'
    pattern = " ".join(map(_to_text, stroke.dash))
    return f'{width} stroke-linejoin="round" stroke-dasharray="{pattern}"'


def _format_faces(paths: Paths, alpha: int) -> Iterator[str]:
    if len(paths.colors) == 1 and not paths.is_gradient.any():
        common, own = _styles(paths.colors, "fill")
    else:
        common, own = _styles(paths.colors, "fill", "stroke")
        width = SMOOTH_SEAM_WIDTH_PX if paths.is_gradient.any() else SEAM_WIDTH_PX
        common += f' stroke-width="{_to_text(width)}" stroke-linejoin="round"'
    if alpha < 255:
        # Of the group as a whole: polygons do not show through one another.
        common += f' opacity="{_to_text(alpha / 255)}"'
    yield f'<g class="faces"{common}>\n'
    if paths.axes is None or paths.end_colors is None:
        yield from _format_paths(paths, own)
    else:
        gradients = _format_gradients(paths.axes, paths.end_colors, paths.is_gradient)
        references = [f' fill="url(#{name})" stroke="url(#{name})"' if name else "" for name, _ in gradients]
        own = [reference or colors for reference, colors in zip(references, own, strict=True)]
        for (_, gradient), path in zip(gradients, _format_paths(paths, own), strict=True):
            yield gradient + path
    yield "</g>\n"


def _format_gradients(axes: FloatArray, ends: Bytes, is_gradient: BoolArray) -> list[tuple[str, str]]:
    """Return the id of the gradient of each path, and its element; two empty texts for none.

    An id tells apart the gradients of all documents, which a page may hold several of, and no model has one with a dot.
    """
    prefix = f"g{zlib.crc32(axes.tobytes() + ends.tobytes()):08x}"
    result = []
    for i, (axis, colors, varies) in enumerate(zip(axes.round(2).tolist(), ends, is_gradient.tolist(), strict=True)):
        if not varies:
            result.append(("", ""))
            continue
        x1, y1, x2, y2 = (f"{value:.10g}" for value in axis)
        first, last = (color[:3].tobytes().hex() for color in colors)
        name = f"{prefix}.{i}"
        element = (
            f'<linearGradient id="{name}" gradientUnits="userSpaceOnUse" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}">'
            f'<stop stop-color="#{first}"/><stop offset="1" stop-color="#{last}"/></linearGradient>\n'
        )
        result.append((name, element))
    return result


def _format_lines(name: str, paths: Paths, style: str) -> Iterator[str]:
    if len(paths.colors) == 0:
        return
    common, own = _styles(paths.colors, "stroke")
    if paths.phases is not None:
        starts = [f' stroke-dashoffset="{_to_text(phase / 100)}"' if phase else "" for phase in paths.phases.tolist()]
        own = list(map(str.__add__, own, starts))
    yield f'<g class="{name}" fill="none"{common}{style}>\n'
    yield from _format_paths(paths, own)
    yield "</g>\n"


def _format_paths(paths: Paths, attributes: list[str]) -> Iterator[str]:
    after = np.where(paths.ends & paths.closed, b"z", b"")
    before, (x, y) = np.where(paths.begins, b"M", b" "), paths.points.T
    text, row_offsets = format_rows(before, x, b" ", y, after)
    data, offsets = text.decode("ascii"), row_offsets[paths.offsets].tolist()
    return (
        f'<path{own} d="{data[start:end]}"/>\n'
        for own, start, end in zip(attributes, offsets[:-1], offsets[1:], strict=True)
    )


def _format_points(points: Points) -> Iterator[str]:
    colors = quantize_colors(points.colors, len(points.circles))
    is_shown = colors[:, 3] > 0
    if not is_shown.any():
        return
    x, y, radius = (to_fixed_point(values) for values in (points.circles[is_shown] * (1.0, 1.0, 0.5)).T)
    common, own = _styles(colors[is_shown], "fill")
    columns = (b'<circle cx="', x, b'" cy="', y, b'" r="', radius, b'"', np.array(own, np.bytes_), b"/>\n")
    yield f'<g class="points"{common}>\n'
    yield format_rows(*columns)[0].decode("ascii")
    yield "</g>\n"


def _styles(colors: Bytes, *kinds: str) -> tuple[str, list[str]]:
    """Return attributes that set the first colour, and for each colour those that set it where it differs."""
    common = colors[0]
    unique, index = unique_colors(colors)
    own = [_paint(color, *kinds, common=common) for color in unique]
    return _paint(common, *kinds), [own[i] for i in index.tolist()]


def _paint(color: Bytes, *kinds: str, common: Bytes | None = None) -> str:
    """Return attributes that set a colour for `kinds`, "fill" and "stroke", except those that equal `common`'s."""
    attributes = []
    for kind in kinds:
        if common is None or (color[:3] != common[:3]).any():
            attributes.append(f' {kind}="#{color[:3].tobytes().hex()}"')
        if color[3] != (255 if common is None else common[3]):
            attributes.append(f' {kind}-opacity="{_to_text(color[3] / 255)}"')
    return "".join(attributes)


def _to_text(value: float) -> str:
    return f"{value:.6g}"
