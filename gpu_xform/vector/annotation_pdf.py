"""Annotations in PDF: real text in embedded fonts, over a halo of outlines, and simple shapes."""

import io
from collections.abc import Iterator, Sequence
from itertools import pairwise
from types import ModuleType
from typing import Any

from ..annotation.fonts import Font
from ..annotation.items import Annotation, Disc, Line, Rectangle, Shape, Text
from ..annotation.text_style import HALO_WIDTH
from ..errors import MissingExtraError
from ..imaging.colors import Rgba

_BEND = 0.5523  # of a Bezier curve that is a quarter of a circle
_UNITS = 1000.0  # of a PDF font per size
_IS_SYMBOLIC = 4  # a flag: the font has glyphs of its own numbers


class AnnotationWriter:
    """Writes the commands of an annotation, and the fonts that they name.

    alpha_state : returns the command that sets an opacity, from 0 to 255
    """

    def __init__(self, pydyf: ModuleType, pdf: Any, alpha_state: Any) -> None:
        self._pydyf = pydyf
        self._pdf = pdf
        self._alpha_state = alpha_state
        self.fonts: dict[str, Any] = {}

    def draw(self, annotation: Annotation) -> Iterator[bytes]:
        """Yield the commands, in pixels from the top left corner."""
        yield from map(self._draw_shape, annotation.shapes)
        if not annotation.texts:
            return
        opened = _open_fonts(annotation.texts)
        for text in annotation.texts:
            yield self._draw_halo(text, opened[text.font.path])
        for name, font in enumerate(opened.values()):
            font.resource = f"F{name}"
        for text in annotation.texts:
            yield self._draw_text(text, opened[text.font.path])
        for font in opened.values():
            self.fonts[font.resource] = font.embed(self._pydyf, self._pdf)

    def _draw_shape(self, shape: Shape) -> bytes:
        if isinstance(shape, Line):
            dash = f"[{' '.join(map(_format_number, shape.dash))}] 0 d " if shape.dash else ""
            ends = f"{_numbers(shape.x0, shape.y0)} m {_numbers(shape.x1, shape.y1)} l S"
            return f"q {self._color(shape.color, 'RG')} {_format_number(shape.width)} w {dash}{ends} Q".encode()
        if isinstance(shape, Rectangle):
            left, top, right, bottom = shape.box
            box = _numbers(left, top, right - left, bottom - top)
            return f"q {self._color(shape.color, 'rg')} {box} re f Q".encode()
        return f"q {self._color(shape.color, 'rg')} {_circle(shape)} f Q".encode()

    def _draw_halo(self, text: Text, font: "_EmbeddedFont") -> bytes:
        if text.halo is None:
            return b""
        scale = text.font.size / font.units_per_em
        stretch = font.stretch(text)
        outlines = font.glyph_path(text.text, text.x, text.y, scale * stretch, scale)
        style = f"{self._color(text.halo, 'RG')} {_format_number(2.0 * HALO_WIDTH * text.font.size)} w 1 j 1 J"
        return f"q {style} {outlines} S Q".encode()

    def _draw_text(self, text: Text, font: "_EmbeddedFont") -> bytes:
        size = f"/{font.resource} {_format_number(text.font.size)} Tf {_format_number(100.0 * font.stretch(text))} Tz"
        at = f"1 0 0 -1 {_numbers(text.x, text.y)} Tm"  # the page's y points down, a letter's up
        codes = "".join(f"{font.glyph_id(character):04x}" for character in text.text)
        return f"q {self._color(text.color, 'rg')} BT {size} {at} <{codes}> Tj ET Q".encode()

    def _color(self, color: Rgba, operator: str) -> str:
        *rgb, alpha = color
        return f"{_numbers(*rgb)} {operator} {self._alpha_state(round(255 * alpha))}"


class _EmbeddedFont:
    """A font of a document: the glyphs of some characters, by fontTools."""

    def __init__(self, font: Font, characters: set[str]) -> None:
        from fontTools import subset
        from fontTools.ttLib import TTFont

        options = subset.Options(notdef_outline=True, glyph_names=False, hinting=False, layout_features=[])
        options.drop_tables += ["FFTM", "GSUB", "GPOS", "GDEF", "kern", "DSIG", "BASE", "STAT"]
        self._font = TTFont(io.BytesIO(font.data), fontNumber=0, lazy=True)
        chooser = subset.Subsetter(options)
        chooser.populate(unicodes=[ord(character) for character in characters])
        chooser.subset(self._font)
        self._name = "".join(letter for letter in font.name if letter.isalnum() and letter.isascii()) or "Font"
        self._characters = sorted(characters)
        self._glyphs: dict[int, str] = self._font.getBestCmap() or {}
        self.units_per_em = float(self._font["head"].unitsPerEm)
        self.resource = ""

    def glyph_id(self, character: str) -> int:
        """Return the number of a character's glyph."""
        name = self._glyphs.get(ord(character))
        return 0 if name is None else int(self._font.getGlyphID(name))

    def advance(self, character: str) -> float:
        """Return how far a character moves the next one, in units of the font."""
        name = self._glyphs.get(ord(character), ".notdef")
        return float(self._font["hmtx"][name][0])

    def stretch(self, text: Text) -> float:
        """Return by how much a text must be wider than the font is, to be as wide as it was measured."""
        own = sum(map(self.advance, text.text)) * text.font.size / self.units_per_em
        return text.width / own if own > 0.0 else 1.0

    def glyph_path(self, text: str, x: float, y: float, x_scale: float, y_scale: float) -> str:
        """Return the path of the outlines of a text that begins at (x, y)."""
        from fontTools.pens.transformPen import TransformPen

        pen = _make_path_pen(self._font.getGlyphSet())
        for character in text:
            name = self._glyphs.get(ord(character), ".notdef")
            self._font.getGlyphSet()[name].draw(TransformPen(pen, (x_scale, 0.0, 0.0, -y_scale, x, y)))
            x += self.advance(character) * x_scale
        return " ".join(pen.commands)

    def embed(self, pydyf: ModuleType, pdf: Any) -> Any:
        """Add the font to a document; return its reference."""
        is_cff = "CFF " in self._font
        file = io.BytesIO()
        self._font.save(file, reorderTables=False)
        name, scale = f"/AAAAAA+{self._name}", _UNITS / self.units_per_em
        program = pydyf.Stream([file.getvalue()], {"Subtype": "/OpenType"} if is_cff else None, compress=True)
        pdf.add_object(program)
        head, metrics = self._font["head"], self._font["hhea"]
        box = [round(scale * value) for value in (head.xMin, head.yMin, head.xMax, head.yMax)]
        descriptor = pydyf.Dictionary(
            {
                "Type": "/FontDescriptor",
                "FontName": name,
                "Flags": _IS_SYMBOLIC,
                "FontBBox": pydyf.Array(box),
                "ItalicAngle": 0,
                "Ascent": round(scale * metrics.ascent),
                "Descent": round(scale * metrics.descent),
                "CapHeight": round(scale * metrics.ascent),
                "StemV": 80,
                "FontFile3" if is_cff else "FontFile2": program.reference,
            }
        )
        pdf.add_object(descriptor)
        advances = {self.glyph_id(each): round(scale * self.advance(each)) for each in self._characters}
        widths = pydyf.Array(
            [part for glyph, width in sorted(advances.items()) for part in (glyph, pydyf.Array([width]))]
        )
        glyphs = pydyf.Dictionary(
            {
                "Type": "/Font",
                "Subtype": "/CIDFontType0" if is_cff else "/CIDFontType2",
                "BaseFont": name,
                "CIDSystemInfo": pydyf.Dictionary(
                    {"Registry": pydyf.String("Adobe"), "Ordering": pydyf.String("Identity"), "Supplement": 0}
                ),
                "FontDescriptor": descriptor.reference,
                "W": widths,
                **({} if is_cff else {"CIDToGIDMap": "/Identity"}),
            }
        )
        pdf.add_object(glyphs)
        to_unicode = pydyf.Stream([self._to_unicode()], compress=True)
        pdf.add_object(to_unicode)
        font = pydyf.Dictionary(
            {
                "Type": "/Font",
                "Subtype": "/Type0",
                "BaseFont": name,
                "Encoding": "/Identity-H",
                "DescendantFonts": pydyf.Array([glyphs.reference]),
                "ToUnicode": to_unicode.reference,
            }
        )
        pdf.add_object(font)
        return font.reference

    def _to_unicode(self) -> bytes:
        """Return the map from glyphs to characters, by which viewers find and copy text."""
        pairs = {self.glyph_id(character): character for character in reversed(self._characters)}
        rows = [f"<{glyph:04x}> <{character.encode('utf-16-be').hex()}>" for glyph, character in sorted(pairs.items())]
        blocks = [rows[i : i + 100] for i in range(0, len(rows), 100)]
        ranges = "\n".join(f"{len(block)} beginbfchar\n{chr(10).join(block)}\nendbfchar" for block in blocks)
        return (
            "/CIDInit /ProcSet findresource begin\n12 dict begin\nbegincmap\n"
            "/CIDSystemInfo << /Registry (Adobe) /Ordering (UCS) /Supplement 0 >> def\n"
            "/CMapName /Adobe-Identity-UCS def\n/CMapType 2 def\n"
            "1 begincodespacerange\n<0000> <ffff>\nendcodespacerange\n"
            f"{ranges}\nendcmap\nCMapName currentdict /CMap defineresource pop\nend\nend"
        ).encode()


def _open_fonts(texts: Sequence[Text]) -> dict[str | None, _EmbeddedFont]:
    """Return each font of the texts, by its path."""
    try:
        import fontTools  # noqa: F401
    except ImportError:
        raise MissingExtraError("text in PDF needs fonttools: pip install 'gpu_xform[pdf]'") from None
    characters: dict[str | None, set[str]] = {}
    fonts = {text.font.path: text.font for text in texts}
    for text in texts:
        characters.setdefault(text.font.path, set()).update(text.text)
    return {path: _EmbeddedFont(font, characters[path]) for path, font in fonts.items()}


def _make_path_pen(glyphs: Any) -> Any:
    """Return a pen of fontTools that collects the commands of a path, all curves as cubic ones."""
    from fontTools.pens.basePen import BasePen

    class PathPen(BasePen):  # type: ignore[misc]  # fontTools has no types
        def __init__(self) -> None:
            super().__init__(glyphs)
            self.commands: list[str] = []

        def _moveTo(self, point: tuple[float, float]) -> None:  # noqa: N802
            self.commands.append(f"{_numbers(*point)} m")

        def _lineTo(self, point: tuple[float, float]) -> None:  # noqa: N802
            self.commands.append(f"{_numbers(*point)} l")

        def _curveToOne(self, *points: tuple[float, float]) -> None:  # noqa: N802
            self.commands.append(f"{_numbers(*(value for point in points for value in point))} c")

        def _closePath(self) -> None:  # noqa: N802
            self.commands.append("h")

    return PathPen()


def _circle(disc: Disc) -> str:
    """Return the path of a circle: four Bezier curves."""
    x, y, r = disc.x, disc.y, 0.5 * disc.diameter
    corners = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0))
    path = f"{_numbers(x + r, y)} m"
    for (ax, ay), (bx, by) in pairwise(corners):
        controls = (ax + _BEND * bx, ay + _BEND * by, bx + _BEND * ax, by + _BEND * ay, bx, by)
        path += " " + _numbers(*(center + r * part for center, part in zip((x, y) * 3, controls, strict=True))) + " c"
    return path


def _numbers(*values: float) -> str:
    return " ".join(map(_format_number, values))


def _format_number(value: float) -> str:
    return f"{round(value, 3):.10g}"
