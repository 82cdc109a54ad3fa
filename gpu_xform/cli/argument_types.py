"""Argument types: each function parses the text of one kind of option value; argparse names the option in errors."""

import argparse
import functools
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from .. import matrices
from .._core.arguments import as_float, as_nonzero_vector, as_real_array, as_square_matrix, as_vector, find_axis
from .._core.suggestions import did_you_mean
from .._core.targets import is_zarr_path
from .._core.types import Float64Array
from ..drawing.camera import MIN_MARGIN
from ..drawing.dash_patterns import as_dash_pattern
from ..drawing.enums import HIDDEN_STYLES, SHADE, SHADINGS
from ..drawing.lengths import as_dpi, to_pixels
from ..drawing.sheet import PROJECTIONS, VIEW_NAMES
from ..errors import GpuXformError
from ..geometry.edges import EDGE_SETS
from ..imaging.colors import ColorLike, to_rgba
from ..raster.names import RASTERIZERS
from . import files
from .path_templates import Template
from .paths import STDIO, file_type, require_path, require_type

MAX_ZOOM_FACTOR = 1.0 - 2.0 * MIN_MARGIN

if TYPE_CHECKING:
    from ..formats.limits import FileLimits

Value = TypeVar("Value")

PICTURE_TYPES = ("png", "svg", "pdf")
PAGE_TYPES = ("html", "htm")  # of web pages, which draw the models themselves
REPORT_TYPES = ("html", "json", "xml")
AXES = ("x", "y", "z")
LABEL_SETS = ("names", "indices")
LABEL_FILES = ("txt", "csv")
PIN_SIDES = ("left", "right", "bottom", "top", "back", "front")  # low and high along each axis
PIN_NAMES = (*PIN_SIDES, "corners")


def argument_type(parse: Callable[[str], Value]) -> Callable[[str], Value]:
    """Turn `parse`, which raises ValueError or an error of ours, into an argparse type that shows its messages."""

    @functools.wraps(parse)
    def parse_argument(text: str) -> Value:
        try:
            return parse(text)
        except (ValueError, GpuXformError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return parse_argument


def parse_numbers(text: str, expected: str, *counts: int) -> list[float]:
    """Return the numbers in `text`, separated by commas or spaces; `counts` are the permitted lengths."""
    try:
        values = [float(word) for word in re.split(r"\s*,\s*|\s+", text.strip())]
    except ValueError:
        values = []
    if len(values) not in counts:
        raise ValueError(f"expected {expected}, got {quote(text)}")
    return values


def quote(text: str) -> str:
    """Quote `text`, cut to a readable length."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


@argument_type
def parse_scale(text: str) -> Float64Array:
    """Parse S or X,Y,Z."""
    return matrices.scale(*parse_numbers(text, "one factor, or three, X,Y,Z", 1, 3))


@argument_type
def parse_rotate_x(text: str) -> Float64Array:
    """Parse degrees."""
    return matrices.rotate_x(*parse_numbers(text, "degrees", 1), degrees=True)


@argument_type
def parse_rotate_y(text: str) -> Float64Array:
    """Parse degrees."""
    return matrices.rotate_y(*parse_numbers(text, "degrees", 1), degrees=True)


@argument_type
def parse_rotate_z(text: str) -> Float64Array:
    """Parse degrees."""
    return matrices.rotate_z(*parse_numbers(text, "degrees", 1), degrees=True)


@argument_type
def parse_rotate(text: str) -> Float64Array:
    """Parse an axis and degrees, X,Y,Z,DEG."""
    *axis, degrees = parse_numbers(text, "an axis and degrees, X,Y,Z,DEG", 4)
    return matrices.rotate(axis, degrees, degrees=True)


@argument_type
def parse_translate(text: str) -> Float64Array:
    """Parse X,Y,Z."""
    return matrices.translate(*parse_numbers(text, "three numbers, X,Y,Z", 3))


@argument_type
def parse_shear(text: str) -> Float64Array:
    """Parse xy=0.5,zx=2: x gains 0.5 times y, z gains 2 times x."""
    factors: dict[str, float] = {}
    for part in text.split(","):
        name, _, factor = (word.strip() for word in part.partition("="))
        if name not in {"xy", "xz", "yx", "yz", "zx", "zy"} or name in factors:
            raise ValueError(f"expected each of xy, xz, yx, yz, zx, zy at most once, as in xy=0.5, got {quote(text)}")
        (factors[name],) = parse_numbers(factor, f"a number for {name}", 1)
    return matrices.shear(**factors)


@argument_type
def parse_reflect(text: str) -> Float64Array:
    """Parse the plane's normal, X,Y,Z."""
    return matrices.reflect(parse_numbers(text, "the plane's normal, X,Y,Z", 3))


@argument_type
def parse_project_onto(text: str) -> Float64Array:
    """Parse the plane's normal, X,Y,Z."""
    return matrices.project_onto(parse_numbers(text, "the plane's normal, X,Y,Z", 3))


@argument_type
def parse_perspective_from_eye(text: str) -> Float64Array:
    """Parse the distance of the eye."""
    return matrices.perspective_from_eye(*parse_numbers(text, "one number", 1))


@argument_type
def parse_matrix(text: str) -> Float64Array:
    """Parse sixteen numbers, row by row, or the name of a file that holds them."""
    try:
        return as_square_matrix(np.reshape(parse_numbers(text, "16 numbers", 16), (4, 4)), "the matrix", 4)
    except ValueError:
        if re.fullmatch(r"[-+.,\s\deE]*", text):
            raise
    try:
        return as_square_matrix(files.read_matrix(text), text, 4)
    except OSError as error:
        raise ValueError(f"expected 16 numbers or a file of them, got {quote(text)} ({error.strerror})") from None


@argument_type
def parse_point(text: str) -> Float64Array:
    """Parse X,Y,Z."""
    return as_vector(parse_numbers(text, "three numbers, X,Y,Z", 3), "the point", 3)


@argument_type
def parse_direction(text: str) -> Float64Array:
    """Parse X,Y,Z or an axis: +Y, -z, x."""
    axis = find_axis(text)
    if axis is not None:
        return axis
    numbers = parse_numbers(text, "an axis such as +Y or -Z, or three numbers, X,Y,Z", 3)
    return as_nonzero_vector(numbers, "the direction", 3)


@argument_type
def parse_resolution(text: str) -> tuple[int, int]:
    """Parse W,H or WxH."""
    sides = re.fullmatch(r"0*([1-9]\d{0,8})\s*[x,]\s*0*([1-9]\d{0,8})", text.strip(), re.ASCII | re.IGNORECASE)
    if sides is None:
        raise ValueError(f"expected a width and a height in pixels, W,H or WxH, got {quote(text)}")
    return int(sides[1]), int(sides[2])


@argument_type
def parse_line_width(text: str) -> float | str:
    """Parse a positive number of pixels, or one with a unit, or `auto`."""
    from ..drawing.layer import AUTO

    return AUTO if text == AUTO else _parse_width(text)


@argument_type
def parse_point_size(text: str) -> float | str:
    """Parse a positive number of pixels, or one with a unit."""
    return _parse_width(text)


@argument_type
def parse_font_size(text: str) -> float:
    """Parse a positive number of pixels."""
    return to_pixels(_parse_width(text), "the size")


@argument_type
def parse_axis_titles(text: str) -> tuple[str, ...]:
    """Parse three titles, X,Y,Z, of which some may be empty."""
    titles = tuple(title.strip() for title in text.split(","))
    if len(titles) != 3:
        raise ValueError(f"expected three titles, X,Y,Z, got {quote(text)}")
    return titles


@argument_type
def parse_labels(text: str) -> str | Template:
    """Parse `names`, `indices`, or the name of a file of texts."""
    if text in LABEL_SETS:
        return text
    if file_type(text) not in LABEL_FILES:
        hint = did_you_mean(text, LABEL_SETS)
        raise ValueError(f"expected {' or '.join(LABEL_SETS)}, or a .txt or .csv file, got {quote(text)}{hint}")
    return Template(text)


def _parse_width(text: str) -> float | str:
    from ..drawing.layer import MAX_LINE_WIDTH_PX

    if text[-1:].isalpha():
        width = to_pixels(text, "the width")
    else:
        width = as_float(parse_numbers(text, "a number of pixels, or one with a unit, as 0.35mm", 1)[0], "the width")
    if not 0.0 < width <= MAX_LINE_WIDTH_PX:
        raise ValueError(f"expected a positive number of pixels, at most {MAX_LINE_WIDTH_PX:,.0f}, got {quote(text)}")
    return text if text[-1:].isalpha() else width


@argument_type
def parse_dpi(text: str) -> float:
    """Parse pixels per inch."""
    return as_dpi(*parse_numbers(text, "pixels per inch", 1))


@argument_type
def parse_units(text: str) -> str:
    """Parse the unit of a model's lengths."""
    from ..drawing.page import UNITS_MM

    if text not in UNITS_MM:
        raise ValueError(f"expected {', '.join(UNITS_MM)}, got {quote(text)}")
    return text


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


@argument_type
def parse_dash(text: str) -> str | tuple[float, ...]:
    """Parse lengths in line widths, or a line type of ISO 128."""
    return _parse_dash(text)


def _parse_dash(text: str) -> str | tuple[float, ...]:
    pattern = as_dash_pattern(text, "the pattern")
    return pattern if "," in text else text


@argument_type
def parse_hidden_style(text: str) -> dict[str, object]:
    """Parse color=gray;line-width=0.5;dash=4,2."""
    parse_value = {"color": parse_color, "line-width": _parse_width, "dash": _parse_dash}
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
def parse_file_limits(text: str) -> "FileLimits":
    """Parse limits of model files, such as points=1000000,depth=20."""
    from ..formats.limits import FileLimits

    known = tuple(FileLimits.__dataclass_fields__)
    given: dict[str, float] = {}
    for word in text.split(","):
        name, _, number = word.partition("=")
        try:
            value = float(number)
            if name not in known or name in given:
                raise ValueError
            given[name] = value if name == "cpu_s" else int(value)
        except (ValueError, OverflowError):
            expected = ", ".join(f"{each}=N" for each in known)
            raise ValueError(f"expected {expected}, separated by commas, got {quote(text)}") from None
    return FileLimits(**given)  # type: ignore[arg-type]


@argument_type
def parse_pose(text: str) -> dict[str, float]:
    """Parse the numbers of joints, such as elbow=0.5,wrist=90deg."""
    expected = f"expected JOINT=VALUE or JOINT=VALUEdeg, separated by commas, got {quote(text)}"
    found: dict[str, float] = {}
    for word in text.split(","):
        name, separator, number = word.rpartition("=")
        name, digits = name.strip(), number.strip().removesuffix("deg")
        try:
            value = float(digits)
        except ValueError:
            raise ValueError(expected) from None
        if not name or not separator or name in found or not math.isfinite(value):
            raise ValueError(expected)
        found[name] = math.radians(value) if digits != number.strip() else value
    return found


@argument_type
def parse_tolerance(text: str) -> float:
    """Parse a distance."""
    (value,) = parse_numbers(text, "a number greater than 0", 1)
    if not value > 0:
        raise ValueError(f"expected a number greater than 0, got {text!r}")
    return value


@argument_type
def parse_view_angle(text: str) -> float:
    """Parse degrees between 0 and 180."""
    (degrees,) = parse_numbers(text, "degrees", 1)
    if not 0.0 < degrees < 180.0:
        raise ValueError(f"expected degrees between 0 and 180, got {quote(text)}")
    return degrees


@argument_type
def parse_views(text: str) -> tuple[str, ...]:
    """Parse names of views, separated by commas."""
    names = tuple(name.strip() for name in text.split(","))
    unknown = next((name for name in names if name not in VIEW_NAMES), None)
    if unknown is not None:
        hint = did_you_mean(unknown, VIEW_NAMES)
        raise ValueError(f"expected names among {', '.join(VIEW_NAMES)}, got {quote(unknown)}{hint}")
    if len(set(names)) < len(names):
        raise ValueError(f"expected each view once, got {quote(text)}")
    return names


@argument_type
def parse_projection(text: str) -> str:
    """Parse the angle of a projection."""
    if text not in PROJECTIONS:
        raise ValueError(f"expected {' or '.join(PROJECTIONS)}, got {quote(text)}")
    return text


@argument_type
def parse_angle(text: str) -> float:
    """Parse degrees."""
    (degrees,) = parse_numbers(text, "degrees", 1)
    return degrees


@argument_type
def parse_zoom_factor(text: str) -> float:
    """Parse the part of a picture that is filled, positive."""
    (factor,) = parse_numbers(text, "factor", 1)
    if not 0.0 < factor <= MAX_ZOOM_FACTOR:
        raise ValueError(f"expected a factor above 0 and at most {MAX_ZOOM_FACTOR:g}, got {quote(text)}")
    return factor


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
    return Template(text) if _is_npy_file(text) else _parse_color_or((SHADE, "face", "file"), text)


@argument_type
def parse_point_counts(text: str) -> list[int]:
    """Parse one or more numbers of points, such as 1e6,8e6."""
    expected = "positive whole numbers N,N,..."
    sizes = [parse_numbers(part, expected, 1)[0] for part in text.split(",")]
    if not all(1 <= size <= 1e12 and size.is_integer() for size in sizes):
        raise ValueError(f"expected {expected}, got {quote(text)}")
    return [int(size) for size in sizes]


@argument_type
def parse_file_path(text: str) -> str:
    """Parse the path of a file, not of a folder."""
    require_path(text)
    return text


@argument_type
def parse_points_path(text: str) -> str:
    """Parse the path of a file, or of a Zarr array, which is a folder and may end so."""
    return parse_file_path(stripped if is_zarr_path(stripped := text.rstrip("/\\")) else text)


@argument_type
def parse_grid_scale(text: str) -> tuple[float, ...]:
    """Parse one positive number, or one per axis."""
    values = parse_numbers(text, "one number or three, X,Y,Z", 1, 3)
    if not all(value > 0 for value in values):
        raise ValueError(f"expected positive numbers, got {quote(text)}")
    return tuple(values) * (3 // len(values))


@argument_type
def parse_workers(text: str) -> int:
    """Parse a positive whole number."""
    if not re.fullmatch(r"[1-9]\d{0,3}", text.strip(), re.ASCII):
        raise ValueError(f"expected a number of processes from 1 to 9999, got {quote(text)}")
    return int(text)


@argument_type
def parse_template(text: str) -> Template:
    """Parse a path, with or without placeholders such as {model}."""
    return Template(text)


@argument_type
def parse_report_path(text: str) -> str:
    """Parse the path of a report, whose type there is."""
    return _parse_typed_path(text, REPORT_TYPES)


@argument_type
def parse_sheet_path(text: str) -> str:
    """Parse the path of a contact sheet."""
    return _parse_typed_path(text, PICTURE_TYPES)


def _parse_typed_path(text: str, known: tuple[str, ...]) -> str:
    path = parse_file_path(text)
    if path == STDIO:
        raise ValueError(f"expected a file of type {', '.join(known)}, not standard output")
    require_type(path, known)
    return path


@argument_type
def parse_threshold(text: str) -> float:
    """Parse a number from 0 to 255."""
    (value,) = parse_numbers(text, "a number from 0 to 255", 1)
    if not 0.0 <= value <= 255.0:
        raise ValueError(f"expected a number from 0 to 255, got {quote(text)}")
    return value


@argument_type
def parse_count(text: str) -> int:
    """Parse a whole number, 0 included."""
    if not re.fullmatch(r"\d{1,15}", text.strip(), re.ASCII):
        raise ValueError(f"expected a whole number, got {quote(text)}")
    return int(text)


@argument_type
def parse_number(text: str) -> float:
    """Parse a finite number."""
    return as_float(parse_numbers(text, "one number", 1)[0], "the number")


@argument_type
def parse_count_pair(text: str) -> tuple[int, int]:
    """Parse two whole numbers, N,M."""
    words = text.split(",")
    if len(words) != 2:
        raise ValueError(f"expected two whole numbers, N,M, got {quote(text)}")
    return parse_count(words[0]), parse_count(words[1])


@argument_type
def parse_pins(text: str) -> list[int | str]:
    """Parse numbers of points and names of sides."""
    words = [word.strip() for word in text.split(",")]
    for word in words:
        if word not in PIN_NAMES and not re.fullmatch(r"\d{1,15}", word, re.ASCII):
            hint = did_you_mean(word, PIN_NAMES)
            raise ValueError(f"expected numbers of points, {', '.join(PIN_NAMES)}, got {quote(text)}{hint}")
    return [word if word in PIN_NAMES else int(word) for word in words]


@argument_type
def parse_sphere(text: str) -> tuple[Float64Array, float]:
    """Parse a centre and a radius, X,Y,Z,R."""
    *center, radius = parse_numbers(text, "a centre and a radius, X,Y,Z,R", 4)
    if not 0.0 < radius < math.inf:
        raise ValueError(f"expected a positive radius, got {quote(text)}")
    return as_vector(center, "the centre", 3), radius


@argument_type
def parse_box(text: str) -> tuple[Float64Array, Float64Array]:
    """Parse a centre and the lengths of three sides, X,Y,Z,A,B,C."""
    numbers = parse_numbers(text, "a centre and the lengths of three sides, X,Y,Z,A,B,C", 6)
    center, sides = as_vector(numbers[:3], "the centre", 3), as_vector(numbers[3:], "the sides", 3)
    if (sides <= 0.0).any():
        raise ValueError(f"expected positive lengths of sides, got {quote(text)}")
    return center, sides


@argument_type
def parse_frame_rate(text: str) -> float:
    """Parse frames per second."""
    (fps,) = parse_numbers(text, "one number", 1)
    return fps


@argument_type
def parse_edge_sets(text: str) -> list[str | Template]:
    """Parse one or more names of edge sets or of .npy files."""
    words = [word.strip() for word in text.split(",")]
    if not all(word in EDGE_SETS or _is_npy_file(word) for word in words):
        unknown = next(word for word in words if word not in EDGE_SETS and not _is_npy_file(word))
        hint = did_you_mean(unknown, EDGE_SETS)
        expected = f"{', '.join(EDGE_SETS)}, an .npy file, or several of these"
        raise ValueError(f"expected {expected}, got {quote(text)}{hint}")
    return [word if word in EDGE_SETS else Template(word) for word in words]


@argument_type
def parse_array_file(text: str) -> Template:
    """Parse the name of an .npy file."""
    if not _is_npy_file(text):
        raise ValueError(f"expected an .npy file, got {quote(text)}")
    return Template(text)


@argument_type
def parse_hidden(text: str) -> str:
    """Parse a style of hidden edges."""
    if text not in HIDDEN_STYLES:
        raise ValueError(f"expected {', '.join(HIDDEN_STYLES)}, got {quote(text)}{did_you_mean(text, HIDDEN_STYLES)}")
    return text


@argument_type
def parse_shading(text: str) -> str:
    """Parse how faces are lit."""
    if text not in SHADINGS:
        raise ValueError(f"expected {', '.join(SHADINGS)}, got {quote(text)}{did_you_mean(text, SHADINGS)}")
    return text


@argument_type
def parse_rasterizer(text: str) -> str:
    """Parse the name of a rasteriser."""
    if text not in RASTERIZERS:
        raise ValueError(f"expected {', '.join(RASTERIZERS)}, got {quote(text)}{did_you_mean(text, RASTERIZERS)}")
    return text


@argument_type
def parse_fraction(text: str) -> float:
    """Parse a number from 0 to 1."""
    (value,) = parse_numbers(text, "a number from 0 to 1", 1)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"expected a number from 0 to 1, got {quote(text)}")
    return value


@argument_type
def parse_scalars(text: str) -> str | Template:
    """Parse the name of an axis, of an attribute, or of an .npy file."""
    if text in AXES or not _is_npy_file(text):
        return text
    return Template(text)


@argument_type
def parse_colormap(text: str) -> str:
    """Parse the name of a colormap."""
    from ..imaging.colormaps import apply_colormap

    apply_colormap([0.0], text, None, 1)
    return text


@argument_type
def parse_limits(text: str) -> list[float]:
    """Parse two numbers in ascending order."""
    low, high = parse_numbers(text, "two numbers, LOW,HIGH", 2)
    if not -math.inf < low <= high < math.inf:
        raise ValueError(f"expected two numbers, the lower first, got {quote(text)}")
    return [low, high]


@argument_type
def parse_feature_angle(text: str) -> float:
    """Parse degrees from 0 to 180."""
    (degrees,) = parse_numbers(text, "degrees", 1)
    if not 0.0 <= degrees <= 180.0:
        raise ValueError(f"expected degrees from 0 to 180, got {quote(text)}")
    return degrees


@argument_type
def parse_sigma(text: str) -> tuple[float, float]:
    """Parse one standard deviation, or a vertical and a horizontal one."""
    sigmas = parse_numbers(text, "one number, or two", 1, 2)
    if not all(0.0 <= sigma < math.inf for sigma in sigmas):
        raise ValueError(f"expected numbers that are 0 or more, got {quote(text)}")
    return sigmas[0], sigmas[-1]


@argument_type
def parse_box_side(text: str) -> int:
    """Parse an odd number of pixels."""
    if not re.fullmatch(r"\d{1,5}", text) or int(text) % 2 == 0:
        raise ValueError(f"expected an odd number of pixels, got {quote(text)}")
    return int(text)


@argument_type
def parse_kernel(text: str) -> Float64Array:
    """Parse rows of numbers, separated by semicolons, or the name of a file that holds a row per line."""
    if not re.fullmatch(r"[-+.,;\s\deE]*", text):
        return as_real_array(files.read_table(text), text)
    try:
        rows = [parse_numbers(row, "numbers", *range(1, len(row) + 1)) for row in text.strip("; ").split(";")]
        return as_real_array(rows, "the matrix")
    except ValueError:
        raise ValueError(f"expected rows of as many numbers, got {quote(text)}") from None


def _is_npy_file(text: str) -> bool:
    return text != STDIO and file_type(text) == "npy"
