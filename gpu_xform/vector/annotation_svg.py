"""Annotations in SVG: real text, over a halo that is a copy of its letters, and simple shapes."""

import html
import re
from collections.abc import Iterator, Sequence

from ..annotation.items import Annotation, Disc, Line, Rectangle, Shape, Text
from ..annotation.text_style import HALO_WIDTH
from ..imaging.colors import Rgba

XLINK = "http://www.w3.org/1999/xlink"
ANY_FAMILY = "Helvetica, Arial, sans-serif"  # where the font is missing


def escape_text(text: str) -> str:
    """Return `text` as XML text; characters that XML cannot even escape become U+FFFD."""
    allowed = re.sub("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", text)
    return html.escape(allowed, quote=False)


def format_annotation(annotation: Annotation) -> Iterator[str]:
    """Yield the group of an annotation: its shapes, and its texts, which can be selected and searched.

    The halo is the same text once more as a `use` element, which is not selected: a stroke under the letters by
    `paint-order` would lie over them in programs that do not know it.
    """
    if annotation.is_empty:
        return
    yield '<g id="annotation">\n'
    yield from map(_format_shape, annotation.shapes)
    if annotation.texts:
        halo, first = annotation.texts[0].halo, annotation.texts[0].font
        if halo is not None:
            width = f'stroke-width="{_to_text(2.0 * HALO_WIDTH * first.size)}" stroke-linejoin="round"'
            color = f"{_color('fill', halo)}{_color('stroke', halo)}"
            yield f'<use xmlns:xlink="{XLINK}" xlink:href="#annotation-text"{color} {width}/>\n'
        yield from _format_texts(annotation.texts)
    yield "</g>\n"


def _format_texts(texts: Sequence[Text]) -> Iterator[str]:
    """Yield a group that has no colours of its own around texts that have none: the halo has other ones."""
    yield f'<g{_color("fill", texts[0].color)}>\n<g id="annotation-text">\n'
    for text in texts:
        color = "" if text.color == texts[0].color else _color("fill", text.color)
        family = html.escape(f"'{text.font.family}', {ANY_FAMILY}")
        fitted = f' textLength="{_to_text(text.width)}" lengthAdjust="spacingAndGlyphs"' if len(text.text) > 1 else ""
        at = f'x="{_to_text(text.x)}" y="{_to_text(text.y)}"'
        font = f'font-family="{family}" font-size="{_to_text(text.font.size)}"'
        yield f"<text {at} {font}{fitted}{color}>{escape_text(text.text)}</text>\n"
    yield "</g>\n</g>\n"


def _format_shape(shape: Shape) -> str:
    if isinstance(shape, Disc):
        radius = _to_text(0.5 * shape.diameter)
        return (
            f'<circle cx="{_to_text(shape.x)}" cy="{_to_text(shape.y)}" r="{radius}"{_color("fill", shape.color)}/>\n'
        )
    if isinstance(shape, Rectangle):
        left, top, right, bottom = shape.box
        sides = f'width="{_to_text(right - left)}" height="{_to_text(bottom - top)}"'
        return f'<rect x="{_to_text(left)}" y="{_to_text(top)}" {sides}{_color("fill", shape.color)}/>\n'
    return _format_line(shape)


def _format_line(line: Line) -> str:
    start, end = (f'x{i}="{_to_text(x)}" y{i}="{_to_text(y)}"' for i, x, y in _ends(line))
    dash = f' stroke-dasharray="{" ".join(map(_to_text, line.dash))}"' if line.dash else ""
    return f'<line {start} {end}{_color("stroke", line.color)} stroke-width="{_to_text(line.width)}"{dash}/>\n'


def _ends(line: Line) -> tuple[tuple[int, float, float], tuple[int, float, float]]:
    return (1, line.x0, line.y0), (2, line.x1, line.y1)


def _color(kind: str, color: Rgba) -> str:
    red, green, blue, alpha = (round(255 * part) for part in color)
    opacity = "" if alpha == 255 else f' {kind}-opacity="{_to_text(alpha / 255)}"'
    return f' {kind}="#{red:02x}{green:02x}{blue:02x}"{opacity}'


def _to_text(value: float) -> str:
    return f"{round(value, 2):.10g}"
