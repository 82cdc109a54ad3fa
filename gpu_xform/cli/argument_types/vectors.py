"""Points, directions, and the matrices of transforms and filters."""

import re

import numpy as np

from ... import matrices
from ..._core.arguments import as_nonzero_vector, as_real_array, as_square_matrix, as_vector, find_axis
from ..._core.types import Float64Array
from .. import files
from .texts import argument_type, parse_numbers, quote


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
def parse_kernel(text: str) -> Float64Array:
    """Parse rows of numbers, separated by semicolons, or the name of a file that holds a row per line."""
    if not re.fullmatch(r"[-+.,;\s\deE]*", text):
        return as_real_array(files.read_table(text), text)
    try:
        rows = [parse_numbers(row, "numbers", *range(1, len(row) + 1)) for row in text.strip("; ").split(";")]
        return as_real_array(rows, "the matrix")
    except ValueError:
        raise ValueError(f"expected rows of as many numbers, got {quote(text)}") from None
