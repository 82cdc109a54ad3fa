"""Texts of the command line as values; argparse puts the option's name before what is wrong with one."""

import argparse
import functools
import math
import re
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from .. import matrices
from .._core.arguments import nonzero_vector, number, square_matrix, vector
from .._core.types import Float64Array
from ..drawing.enums import HIDDEN_STYLES
from ..errors import GpuXformError
from ..geometry.edges import EDGE_SETS
from ..imaging.colors import ColorLike, rgba
from . import files
from .path_templates import Template

Value = TypeVar("Value")


def option_value(make: Callable[[str], Value]) -> Callable[[str], Value]:
    """Make of `make`, which raises ValueError or an error of ours, an argparse type whose users see the message."""

    @functools.wraps(make)
    def value(text: str) -> Value:
        try:
            return make(text)
        except (ValueError, GpuXformError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return value


def numbers(text: str, expected: str, *counts: int) -> list[float]:
    """Return the numbers of `text`, separated by commas or spaces; `counts` are the permitted lengths."""
    try:
        values = [float(word) for word in re.split(r"\s*,\s*|\s+", text.strip())]
    except ValueError:
        values = []
    if len(values) not in counts:
        raise ValueError(f"expected {expected}, got {shortened(text)}")
    return values


def shortened(text: str) -> str:
    """Quote `text`, cut to a readable length."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


@option_value
def scale(text: str) -> Float64Array:
    """Read S or X,Y,Z."""
    return matrices.scale(*numbers(text, "one factor or three, X,Y,Z", 1, 3))


@option_value
def rotate_x(text: str) -> Float64Array:
    """Read degrees."""
    return matrices.rotate_x(*numbers(text, "degrees", 1), degrees=True)


@option_value
def rotate_y(text: str) -> Float64Array:
    """Read degrees."""
    return matrices.rotate_y(*numbers(text, "degrees", 1), degrees=True)


@option_value
def rotate_z(text: str) -> Float64Array:
    """Read degrees."""
    return matrices.rotate_z(*numbers(text, "degrees", 1), degrees=True)


@option_value
def rotate(text: str) -> Float64Array:
    """Read an axis and degrees, X,Y,Z,DEG."""
    *axis, degrees = numbers(text, "an axis and degrees, X,Y,Z,DEG", 4)
    return matrices.rotate(axis, degrees, degrees=True)


@option_value
def translate(text: str) -> Float64Array:
    """Read X,Y,Z."""
    return matrices.translate(*numbers(text, "three numbers, X,Y,Z", 3))


@option_value
def shear(text: str) -> Float64Array:
    """Read xy=0.5,zx=2: x gains 0.5 times y, z gains twice x."""
    factors: dict[str, float] = {}
    for part in text.split(","):
        name, _, factor = (word.strip() for word in part.partition("="))
        if name not in {"xy", "xz", "yx", "yz", "zx", "zy"} or name in factors:
            raise ValueError(
                f"expected each of xy, xz, yx, yz, zx, zy once at most, as in xy=0.5, got {shortened(text)}"
            )
        (factors[name],) = numbers(factor, f"a number for {name}", 1)
    return matrices.shear(**factors)


@option_value
def reflect(text: str) -> Float64Array:
    """Read the plane's normal, X,Y,Z."""
    return matrices.reflect(numbers(text, "the plane's normal, X,Y,Z", 3))


@option_value
def project_onto(text: str) -> Float64Array:
    """Read the plane's normal, X,Y,Z."""
    return matrices.project_onto(numbers(text, "the plane's normal, X,Y,Z", 3))


@option_value
def perspective_from_eye(text: str) -> Float64Array:
    """Read the eye's distance."""
    return matrices.perspective_from_eye(*numbers(text, "one number", 1))


@option_value
def matrix(text: str) -> Float64Array:
    """Read sixteen numbers row by row, or the name of a file that holds them."""
    try:
        return square_matrix(np.reshape(numbers(text, "16 numbers", 16), (4, 4)), "the matrix", 4)
    except ValueError:
        if re.fullmatch(r"[-+.,\s\deE]*", text):
            raise
    try:
        return square_matrix(files.read_matrix(text), text, 4)
    except OSError as error:
        raise ValueError(f"expected 16 numbers or a file of them, got {shortened(text)} ({error.strerror})") from None


@option_value
def point(text: str) -> Float64Array:
    """Read X,Y,Z."""
    return vector(numbers(text, "three numbers, X,Y,Z", 3), "the point", 3)


@option_value
def direction(text: str) -> Float64Array:
    """Read X,Y,Z or an axis: +Y, -z, x."""
    axis = re.fullmatch(r"([+-]?)([xyz])", text.strip(), re.IGNORECASE)
    if axis is None:
        return nonzero_vector(numbers(text, "an axis such as +Y or -Z, or three numbers, X,Y,Z", 3), "the direction", 3)
    unit = np.zeros(3)
    unit["xyz".index(axis[2].lower())] = -1.0 if axis[1] == "-" else 1.0
    return unit


@option_value
def resolution(text: str) -> tuple[int, int]:
    """Read W,H or WxH."""
    sides = re.fullmatch(r"0*([1-9]\d{0,8})\s*[x,]\s*0*([1-9]\d{0,8})", text.strip(), re.ASCII | re.IGNORECASE)
    if sides is None:
        raise ValueError(f"expected a width and a height in pixels, W,H or WxH, got {shortened(text)}")
    return int(sides[1]), int(sides[2])


@option_value
def line_width(text: str) -> float:
    """Read a positive number of pixels."""
    from ..drawing.layer import MAX_LINE_WIDTH_PX

    width = number(numbers(text, "one number", 1)[0], "the width")
    if not 0.0 < width <= MAX_LINE_WIDTH_PX:
        raise ValueError(
            f"expected a positive number of pixels, at most {MAX_LINE_WIDTH_PX:,.0f}, got {shortened(text)}"
        )
    return width


@option_value
def view_angle(text: str) -> float:
    """Read degrees between 0 and 180."""
    (degrees,) = numbers(text, "degrees", 1)
    if not 0.0 < degrees < 180.0:
        raise ValueError(f"expected degrees between 0 and 180, got {shortened(text)}")
    return degrees


@option_value
def color(text: str) -> ColorLike:
    """Read a colour's name, #rrggbb, or R,G,B from 0 to 1."""
    value: ColorLike = text
    if re.match(r"\s*[-+.\d]+[^,\s]*[,\s]", text):
        value = numbers(text, "three or four numbers from 0 to 1", 3, 4)
    rgba(value, "the value")
    return value


@option_value
def line_color(text: str) -> ColorLike:
    """Read a colour, or `face`."""
    return text if text == "face" else color(text)


@option_value
def fill(text: str) -> ColorLike | Template:
    """Read a colour, `face`, or the name of an .npy file."""
    return Template(text) if _is_array(text) else line_color(text)


@option_value
def counts(text: str) -> list[int]:
    """Read one or more numbers of points, such as 1e6,8e6."""
    expected = "positive whole numbers N,N,..."
    sizes = [numbers(part, expected, 1)[0] for part in text.split(",")]
    if not all(1 <= size <= 1e12 and size.is_integer() for size in sizes):
        raise ValueError(f"expected {expected}, got {shortened(text)}")
    return [int(size) for size in sizes]


@option_value
def file_path(text: str) -> str:
    """Read the path of a file, which a folder's is not."""
    files.require_path(text)
    return text


@option_value
def template(text: str) -> Template:
    """Read a path, with or without {model} or {folder}."""
    return Template(file_path(text))


@option_value
def threshold(text: str) -> float:
    """Read a number from 0 to 255."""
    (value,) = numbers(text, "a number from 0 to 255", 1)
    if not 0.0 <= value <= 255.0:
        raise ValueError(f"expected a number from 0 to 255, got {shortened(text)}")
    return value


@option_value
def count(text: str) -> int:
    """Read a whole number, 0 included."""
    if not re.fullmatch(r"\d{1,15}", text.strip(), re.ASCII):
        raise ValueError(f"expected a whole number, got {shortened(text)}")
    return int(text)


@option_value
def rate(text: str) -> float:
    """Read frames a second."""
    (fps,) = numbers(text, "one number", 1)
    return fps


@option_value
def edge_sets(text: str) -> list[str | Template]:
    """Read one or more names of edge sets or of .npy files."""
    words = [word.strip() for word in text.split(",")]
    if not all(word in EDGE_SETS or _is_array(word) for word in words):
        raise ValueError(f"expected {', '.join(EDGE_SETS)}, an .npy file, or several of these, got {shortened(text)}")
    return [word if word in EDGE_SETS else Template(word) for word in words]


@option_value
def array_file(text: str) -> Template:
    """Read the name of an .npy file."""
    if not _is_array(text):
        raise ValueError(f"expected an .npy file, got {shortened(text)}")
    return Template(text)


def _is_array(text: str) -> bool:
    return text != files.STANDARD and files.kind(text) == "npy"


@option_value
def hidden(text: str) -> str:
    """Read what is done with hidden edges."""
    if text not in HIDDEN_STYLES:
        raise ValueError(f"expected {', '.join(HIDDEN_STYLES)}, got {shortened(text)}")
    return text


@option_value
def fraction(text: str) -> float:
    """Read a number from 0 to 1."""
    (value,) = numbers(text, "a number from 0 to 1", 1)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"expected a number from 0 to 1, got {shortened(text)}")
    return value


AXES = ("x", "y", "z")


@option_value
def scalars(text: str) -> str | Template:
    """Read the name of an axis or of an .npy file."""
    if text in AXES:
        return text
    if not _is_array(text):
        raise ValueError(f"expected x, y, z or an .npy file, got {shortened(text)}")
    return Template(text)


@option_value
def cmap(text: str) -> str:
    """Read the name of a colormap."""
    from ..imaging.colormaps import mapped

    mapped([0.0], text, None, 1)
    return text


@option_value
def limits(text: str) -> list[float]:
    """Read two numbers, the lower before."""
    low, high = numbers(text, "two numbers, LOW,HIGH", 2)
    if not -math.inf < low <= high < math.inf:
        raise ValueError(f"expected two numbers, the lower before, got {shortened(text)}")
    return [low, high]


@option_value
def feature_angle(text: str) -> float:
    """Read degrees from 0 to 180."""
    (degrees,) = numbers(text, "degrees", 1)
    if not 0.0 <= degrees <= 180.0:
        raise ValueError(f"expected degrees from 0 to 180, got {shortened(text)}")
    return degrees
