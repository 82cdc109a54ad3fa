"""Fonts: Pillow's built-in one, a file, or one that is installed, and what they measure."""

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._core.suggestions import did_you_mean
from .._core.types import StrPath
from ..errors import ArgumentError, ArgumentTypeError

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

FONT_TYPES = (".ttf", ".otf", ".ttc", ".otc")
BUILT_IN = "Aileron"  # Pillow's own; it has the letters of English and some more
# Where the built-in font lacks a character, the first of these has it that is installed: wide fonts first.
FALLBACKS = (
    *("DejaVuSans", "NotoSans-Regular", "LiberationSans-Regular", "Arial", "Arial Unicode", "Helvetica", "segoeui"),
    *("NotoSansCJK-Regular", "NotoSansCJKjp-Regular", "msgothic", "Hiragino Sans GB", "unifont"),
)
_NO_CHARACTER = "\uffff"  # which no font has: it shows what stands for missing ones
_MAX_LISTED = 12
MIN_FONT_SIMILARITY = 0.6


@dataclass(frozen=True)
class Font:
    """A font at a size, in pixels.

    path : the file; None for the built-in font
    """

    path: str | None
    size: float

    @cached_property
    def pillow(self) -> "FreeTypeFont":
        """The font as Pillow draws it."""
        return _open_font(self.path, self.size)

    @cached_property
    def data(self) -> bytes:
        """The font's file."""
        if self.path is not None:
            return Path(self.path).read_bytes()
        file: Any = self.pillow.path  # in memory, as Pillow gives its own font
        data: bytes = file.getvalue()
        return data

    @cached_property
    def family(self) -> str:
        """The name of the family, such as "DejaVu Sans"."""
        return self.pillow.getname()[0] or BUILT_IN

    @cached_property
    def name(self) -> str:
        """The name in messages, such as "DejaVu Sans Bold"."""
        family, style = self.pillow.getname()
        return family or BUILT_IN if style in {None, "Regular", "Book"} else f"{family} {style}"

    @cached_property
    def ascent(self) -> float:
        """How far capitals reach above the baseline."""
        return float(-self.pillow.getbbox("H", anchor="ls")[1])

    @cached_property
    def descent(self) -> float:
        """How far letters reach below the baseline."""
        return float(self.pillow.getbbox("g", anchor="ls")[3])

    def measure(self, text: str) -> tuple[float, float, float]:
        """Return the advance of a line of text, and how far it reaches above and below the baseline."""
        _, top, _, bottom = self.pillow.getbbox(text, anchor="ls")
        return float(self.pillow.getlength(text)), max(self.ascent, -top), max(self.descent, bottom)

    def first_missing(self, text: str) -> str | None:
        """Return the first character of `text` that the font lacks; None if it has all."""
        return next((character for character in text if _is_missing(self.path, character)), None)


@lru_cache(maxsize=64)
def _open_font(path: str | None, size: float) -> "FreeTypeFont":
    from PIL import ImageFont

    layout = ImageFont.Layout.BASIC  # a glyph per character, in all back ends and on all machines alike
    if path is None:
        font = ImageFont.load_default(size)
        if not isinstance(font, ImageFont.FreeTypeFont):
            raise ArgumentError("text needs Pillow with FreeType, which this one was built without")
        return font.font_variant(layout_engine=layout)
    return ImageFont.truetype(path, size, layout_engine=layout)


@lru_cache(maxsize=1 << 14)
def _is_missing(path: str | None, character: str) -> bool:
    """Say whether a font shows a character as it shows those that no font has."""
    if character.isspace():
        return False
    font = _open_font(path, 32.0)
    masks = [font.getmask2(each, mode="1") for each in (character, _NO_CHARACTER)]
    (mask, offset), (none, none_offset) = masks
    return (mask.size, offset, bytes(mask)) == (none.size, none_offset, bytes(none))


def find_font(font: StrPath | None, size: float) -> Font:
    """Return the font of a path or a name, at a size in pixels; None is the built-in font.

    Raises `ArgumentError` for what is no font, which names fonts that there are.
    """
    if font is None:
        return Font(None, size)
    if not isinstance(font, str | os.PathLike):
        raise ArgumentTypeError.expecting("font", "be the path or the name of a font", type(font).__name__)
    path = Path(os.fspath(font))
    if path.is_file():
        found = Font(str(path), size)
        try:
            _ = found.pillow
        except OSError as error:
            raise ArgumentError.expecting(
                "font", "be a TrueType or OpenType font", repr(str(path)), reason=error
            ) from None
        return found
    installed = list_fonts()
    match = installed.get(_simplify(path.name.removesuffix(path.suffix) if path.suffix in FONT_TYPES else path.name))
    if match is None:
        names = sorted({Path(each).stem for each in installed.values()})
        hint = did_you_mean(path.name, names, MIN_FONT_SIMILARITY)
        listed = ", ".join(names[:_MAX_LISTED]) or "none"
        others = f" and {len(names) - _MAX_LISTED} more" if len(names) > _MAX_LISTED else ""
        raise ArgumentError.expecting(
            "font",
            "be the path or the name of a font",
            f"{str(path)!r}{hint}",
            reason=f"installed are {listed}{others}",
        )
    return Font(match, size)


def choose_font(text: str, chosen: Font, name: str) -> Font:
    """Return the font that shows a text: `chosen`, or for the built-in one another that has all characters.

    Raises `ArgumentError`, which calls the text `name`, if no font has them: no character is left out.
    """
    missing = chosen.first_missing(text)
    if missing is None:
        return chosen
    if chosen.path is None:
        for path in _fallback_paths():
            other = Font(path, chosen.size)
            if other.first_missing(text) is None:
                return other
    hint = "give a font that has them" if chosen.path is None else "give another font"
    raise ArgumentError.expecting(
        name, f"have characters that the font {chosen.name} has", f"{missing!r} in {text!r}; {hint}"
    )


@cache
def _fallback_paths() -> list[str]:
    installed = list_fonts()
    return [installed[key] for key in map(_simplify, FALLBACKS) if key in installed]


@cache
def list_fonts() -> dict[str, str]:
    """Return the paths of the fonts that are installed, by their names without spaces, hyphens and capitals."""
    paths = sorted(path for folder in _font_folders() for path in _walk(folder))
    fonts = {_simplify(Path(path).stem): path for path in reversed(paths)}
    for key in [key for key in fonts if key.endswith("regular")]:
        fonts.setdefault(key.removesuffix("regular"), fonts[key])
    return fonts


def _walk(folder: Path) -> Iterator[str]:
    for parent, _, files in os.walk(folder):
        yield from (str(Path(parent, file)) for file in files if file.lower().endswith(FONT_TYPES))


def _font_folders() -> list[Path]:
    home = Path.home()
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA", str(home))
        return [Path(os.environ.get("WINDIR", "C:/Windows"), "Fonts"), Path(local, "Microsoft/Windows/Fonts")]
    if sys.platform == "darwin":
        return [Path("/System/Library/Fonts"), Path("/Library/Fonts"), home / "Library/Fonts"]
    data = os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"
    own = os.environ.get("XDG_DATA_HOME") or str(home / ".local/share")
    return [Path(folder, "fonts") for folder in (*data.split(":"), own) if folder] + [home / ".fonts"]


def _simplify(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter not in " -_")
