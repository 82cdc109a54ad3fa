"""Styles of models: edges, lines, colours, labels and sections."""

import argparse
import re

from ..._core.arguments import as_float, as_nonzero_vector, find_axis
from ..._core.suggestions import did_you_mean
from ...drawing.dash_patterns import as_dash_pattern
from ...drawing.enums import HIDDEN_STYLES, SHADE, SHADINGS
from ...drawing.lengths import to_pixels
from ...geometry.edges import EDGE_SETS
from ...imaging.colors import ColorLike, to_rgba
from ..path_templates import Template
from ..paths import file_type
from .paths import is_npy_file
from .texts import argument_type, parse_numbers, quote

AXES = ("x", "y", "z")
LABEL_SETS = ("names", "indices")
LABEL_FILES = ("txt", "csv")


@argument_type
def parse_edge_sets(text: str) -> list[str | Template]:
    """Parse one or more names of edge sets or of .npy files."""
    words = [word.strip() for word in text.split(",")]
    if not all(word in EDGE_SETS or is_npy_file(word) for word in words):
        unknown = next(word for word in words if word not in EDGE_SETS and not is_npy_file(word))
        hint = did_you_mean(unknown, EDGE_SETS)
        expected = f"{', '.join(EDGE_SETS)}, an .npy file, or several of these"
        raise ValueError(f"expected {expected}, got {quote(text)}{hint}")
    return [word if word in EDGE_SETS else Template(word) for word in words]


@argument_type
def parse_hidden(text: str) -> str:
    """Parse a style of hidden edges."""
    if text not in HIDDEN_STYLES:
        raise ValueError(f"expected {', '.join(HIDDEN_STYLES)}, got {quote(text)}{did_you_mean(text, HIDDEN_STYLES)}")
    return text


@argument_type
def parse_hidden_style(text: str) -> dict[str, object]:
    """Parse color=gray;line-width=0.5;dash=4,2."""
    parse_value = {"color": parse_color, "line-width": parse_width, "dash": parse_dash}
    style: dict[str, object] = {}
    for part in re.split(r"\s*;\s*", text.strip().rstrip(";")):
        key, _, value = (word.strip() for word in part.partition("="))
        if key not in parse_value or key.replace("-", "_") in style:
            hint = did_you_mean(key, parse_value)
            expected = f"each of {', '.join(parse_value)} at most once, as in color=gray;dash=4,2"
            raise ValueError(f"expected {expected}, got {quote(text)}{hint}")
        try:
            style[key.replace("-", "_")] = parse_value[key](value)
        except (ValueError, argparse.ArgumentTypeError) as error:
            raise ValueError(f"{key}: {error}") from None
    return style


@argument_type
def parse_line_width(text: str) -> float | str:
    """Parse a positive number of pixels, or one with a unit, or `auto`."""
    from ...drawing.layer import AUTO

    return AUTO if text == AUTO else parse_width(text)


@argument_type
def parse_point_size(text: str) -> float | str:
    """Parse a positive number of pixels, or one with a unit."""
    return parse_width(text)


def parse_width(text: str) -> float | str:
    """Return a positive number of pixels, or a text with a unit."""
    from ...drawing.layer import MAX_LINE_WIDTH_PX

    if text[-1:].isalpha():
        width = to_pixels(text, "the width")
    else:
        width = as_float(parse_numbers(text, "a number of pixels, or one with a unit, as 0.35mm", 1)[0], "the width")
    if not 0.0 < width <= MAX_LINE_WIDTH_PX:
        raise ValueError(f"expected a positive number of pixels, at most {MAX_LINE_WIDTH_PX:,.0f}, got {quote(text)}")
    return text if text[-1:].isalpha() else width


@argument_type
def parse_dash(text: str) -> str | tuple[float, ...]:
    """Parse lengths in line widths, or a line type of ISO 128."""
    pattern = as_dash_pattern(text, "the pattern")
    return pattern if "," in text else text


@argument_type
def parse_color(text: str) -> ColorLike:
    """Parse a colour's name, #rrggbb, or R,G,B from 0 to 1."""
    value: ColorLike = text
    if re.match(r"\s*[-+.\d]+[^,\s]*[,\s]", text):
        value = parse_numbers(text, "three or four numbers from 0 to 1", 3, 4)
    to_rgba(value, "the value")
    return value


@argument_type
def parse_line_color(text: str) -> ColorLike:
    """Parse a colour, `face` or `file`."""
    return _parse_color_or(("face", "file"), text)


def _parse_color_or(words: tuple[str, ...], text: str) -> ColorLike:
    try:
        return text if text in words else parse_color(text)
    except argparse.ArgumentTypeError as error:
        also = f"{', '.join(words[:-1])} or {words[-1]}"
        raise ValueError(f"{error}; it may also be {also}{did_you_mean(text, words)}") from None


@argument_type
def parse_fill(text: str) -> ColorLike | Template:
    """Parse a colour, `face`, `file`, `shade`, or the name of an .npy file."""
    return Template(text) if is_npy_file(text) else _parse_color_or((SHADE, "face", "file"), text)


@argument_type
def parse_shading(text: str) -> str:
    """Parse how faces are lit."""
    if text not in SHADINGS:
        raise ValueError(f"expected {', '.join(SHADINGS)}, got {quote(text)}{did_you_mean(text, SHADINGS)}")
    return text


@argument_type
def parse_scalars(text: str) -> str | Template:
    """Parse the name of an axis, of an attribute, or of an .npy file."""
    if text in AXES or not is_npy_file(text):
        return text
    return Template(text)


@argument_type
def parse_colormap(text: str) -> str:
    """Parse the name of a colormap."""
    from ...imaging.colormaps import apply_colormap

    apply_colormap([0.0], text, None, 1)
    return text


@argument_type
def parse_labels(text: str) -> str | Template:
    """Parse `names`, `indices`, or the name of a file of texts."""
    if text in LABEL_SETS:
        return text
    if file_type(text) not in LABEL_FILES:
        hint = did_you_mean(text, LABEL_SETS)
        raise ValueError(f"expected {' or '.join(LABEL_SETS)}, or a .txt or .csv file, got {quote(text)}{hint}")
    return Template(text)


@argument_type
def parse_section(text: str) -> tuple[list[float], list[float]]:
    """Parse a point and a normal, X,Y,Z,NX,NY,NZ, or a point and an axis, X,Y,Z,+X."""
    point, _, last = text.rpartition(",")
    if (axis := find_axis(last)) is not None:
        return parse_numbers(point, "a point and an axis, X,Y,Z,+X", 3), axis.tolist()
    numbers = parse_numbers(text, "a point and a normal, X,Y,Z,NX,NY,NZ or X,Y,Z,+X", 6)
    as_nonzero_vector(numbers[3:], "the normal", 3)
    return numbers[:3], numbers[3:]


@argument_type
def parse_hatch(text: str) -> bool | float | tuple[float, float]:
    """Parse `auto`, degrees, or degrees and a distance."""
    if text == "auto":
        return True
    numbers = parse_numbers(text, "auto, degrees, or degrees and a distance, DEG,D", 1, 2)
    if len(numbers) == 1:
        return numbers[0]
    if not numbers[1] > 0.0:
        raise ValueError(f"expected a positive distance, got {quote(text)}")
    return numbers[0], numbers[1]
