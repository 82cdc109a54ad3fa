"""Pictures as SVG, one group a model, for browsers and for designers."""

import html
import re
import unicodedata
from collections.abc import Iterator, Sequence

import numpy as np

from ..imaging.colors import FloatColor
from .decimal_text import Octets, hundredths, rows
from .layer import Dots, Strokes, dash_pattern
from .paths import SEAM, Paths, distinct, face_paths, line_paths, octets


def svg(size: tuple[int, int], background: FloatColor, layers: Sequence[Strokes]) -> str:
    """Return an SVG document, `size` pixels wide and high, that shows each layer over those before it.

    A model is a group with an id made of its name, its name as the title, and groups of class "faces", "hidden",
    "visible" and "points" for what it has. Colours, widths and dashes are attributes of these groups, and of a path
    only where it differs. Coordinates are rounded to hundredths of a pixel.
    """
    width, height = size
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">\n'
    ]
    if background[3] > 0.0:
        paint = _paint(octets(np.array([background]), 1)[0], "fill")
        parts.append(f'<rect id="background" width="{width}" height="{height}"{paint}/>\n')
    names = [layer.name for layer in layers]
    for layer, identifier in zip(layers, _identifiers(names), strict=True):
        parts.append(f'<g id="{identifier}">\n')
        if layer.name:
            parts.append(f"<title>{_escaped(layer.name)}</title>\n")
        parts.extend(_model(layer))
        parts.append("</g>\n")
    parts.append("</svg>\n")
    return "".join(parts)


def _escaped(text: str) -> str:
    """Return `text` as XML holds it; a replacement stands for each character that XML cannot even escape."""
    known = re.sub("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", text)
    return html.escape(known, quote=False)


def _identifiers(names: Sequence[str]) -> Iterator[str]:
    """Yield an id for each name: its letters and digits as far as ASCII has them, and a number where others have it."""
    taken, counts = {"background"}, dict[str, int]()
    for name in names:
        plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
        base = re.sub(r"[^A-Za-z0-9_]+", "-", plain).strip("-")
        if not base[:1].isalpha():
            base = f"model-{base}".rstrip("-")
        identifier = base
        while identifier in taken:
            counts[base] = counts.get(base, 1) + 1
            identifier = f"{base}-{counts[base]}"
        taken.add(identifier)
        yield identifier


def _model(layer: Strokes) -> Iterator[str]:
    if layer.polygons is not None:
        for alpha, paths in face_paths(layer.polygons):
            yield from _faces(paths, alpha)
    width = f' stroke-width="{_number(layer.line_width)}"'
    solid = f'{width} stroke-linecap="round" stroke-linejoin="round"'
    dashed = f'{width} stroke-dasharray="{" ".join(map(_number, dash_pattern(layer.line_width)))}"'
    hidden = line_paths(layer, hidden=True)
    yield from _lines("hidden", hidden, solid if hidden.phases is None else dashed)
    yield from _lines("visible", line_paths(layer, hidden=False), solid)
    if layer.dots is not None:
        yield from _dots(layer.dots)


def _faces(paths: Paths, alpha: int) -> Iterator[str]:
    if len(paths.colors) == 1:
        common, own = _styles(paths.colors, "fill")
    else:
        common, own = _styles(paths.colors, "fill", "stroke")
        common += f' stroke-width="{_number(SEAM)}" stroke-linejoin="round"'
    if alpha < 255:
        common += f' opacity="{_number(alpha / 255)}"'  # of all together: none shines through another
    yield f'<g class="faces"{common}>\n'
    yield from _elements(paths, own)
    yield "</g>\n"


def _lines(name: str, paths: Paths, style: str) -> Iterator[str]:
    if len(paths.colors) == 0:
        return
    common, own = _styles(paths.colors, "stroke")
    if paths.phases is not None:
        starts = [f' stroke-dashoffset="{_number(phase / 100)}"' if phase else "" for phase in paths.phases.tolist()]
        own = list(map(str.__add__, own, starts))
    yield f'<g class="{name}" fill="none"{common}{style}>\n'
    yield from _elements(paths, own)
    yield "</g>\n"


def _elements(paths: Paths, own: list[str]) -> Iterator[str]:
    after = np.where(paths.ends & paths.closed, b"z", b"")
    text, rows_at = rows(np.where(paths.begins, b"M", b" "), paths.points[:, 0], b" ", paths.points[:, 1], after)
    data, at = text.decode("ascii"), rows_at[paths.offsets].tolist()
    return (f'<path{word} d="{data[a:b]}"/>\n' for word, a, b in zip(own, at[:-1], at[1:], strict=True))


def _dots(dots: Dots) -> Iterator[str]:
    colors = octets(dots.colors, len(dots.circles))
    shown = colors[:, 3] > 0
    x, y, diameter = dots.circles[shown].T
    if len(x) == 0:
        return
    common, own = _styles(colors[shown], "fill")
    columns = (b'<circle cx="', hundredths(x), b'" cy="', hundredths(y), b'" r="', hundredths(0.5 * diameter))
    yield f'<g class="points"{common}>\n'
    yield rows(*columns, b'"', np.array(own, np.bytes_), b"/>\n")[0].decode("ascii")
    yield "</g>\n"


def _styles(colors: Octets, *kinds: str) -> tuple[str, list[str]]:
    """Return attributes that paint in the first colour, and for each colour those to add to paint in it."""
    common = colors[0]
    found, which = distinct(colors)
    words = [_paint(color, *kinds, common=common) for color in found]
    return _paint(common, *kinds), [words[i] for i in which.tolist()]


def _paint(color: Octets, *kinds: str, common: Octets | None = None) -> str:
    """Return attributes for each of `kinds`, "fill" or "stroke", as far as `common` does not say the same."""
    words = []
    for kind in kinds:
        if common is None or (color[:3] != common[:3]).any():
            words.append(f' {kind}="#{color[:3].tobytes().hex()}"')
        if color[3] != (255 if common is None else common[3]):
            words.append(f' {kind}-opacity="{_number(color[3] / 255)}"')
    return "".join(words)


def _number(value: float) -> str:
    return f"{value:.6g}"
