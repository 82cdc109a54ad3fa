"""Grids of points and strands, such as cloth and hair, which springs can join."""

import math

import numpy as np

from .._core.arguments import as_float
from .._core.types import Float64Array
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from ..geometry.strands import Strands
from ._arguments import as_count, as_length
from ._polyhedra import PHI

_MAX_SPRING_POINTS = 1 << 27  # of a cloth or of hair: 3 GB


def grid(n: int) -> Mesh:
    """Return the square [-1, 1]^2 in the xy-plane as n x n quads that face +z: (n + 1)^2 points.

    Parameters
    ----------
    n : int
        The number of quads along each side, at least 1.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n must be at least 1, got 0".
    """
    n = as_count(n, "n", 1)
    steps = np.linspace(-1.0, 1.0, n + 1)
    y, x = np.meshgrid(steps, steps, indexing="ij")
    return _join_rows(np.stack([x, y, np.zeros_like(x)], axis=-1))


def cloth(n: int, m: int, width: float = 1.0, depth: float = 1.0) -> Mesh:
    """Return a cloth that lies flat in the xz-plane, as n x m quads that face +y: (n + 1) (m + 1) points.

    Its centre is the origin. Points follow one another along x, and rows along z: the first n + 1 points are the row at
    the back, so points 0 and n are the corners there.

    Parameters
    ----------
    n : int
        The number of quads along x, at least 1.
    m : int
        The number of quads along z, at least 1.
    width : float
        Its length along x, in metres.
    depth : float
        Its length along z, in metres.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n must be at least 1, got 0", "width must be positive, got -1".
    """
    n, m = as_count(n, "n", 1), as_count(m, "m", 1)
    _require_room((n + 1) * (m + 1), "n")
    width, depth = as_length(width, "width"), as_length(depth, "depth")
    z, x = np.meshgrid(_spread(m, depth), _spread(n, width), indexing="ij")
    return _join_rows(np.stack([x, np.zeros_like(x), z], axis=-1), is_downwards=True)


def curtain(
    n: int, m: int, width: float = 1.0, height: float = 1.0, pleats: int = 8, pleat_depth: float = 0.04
) -> Mesh:
    """Return a pleated curtain that hangs from the x-axis, as n x m quads that face +z: (n + 1) (m + 1) points.

    The first n + 1 points are the top row, along x: pin them, or some of them. The depth of the pleats is
    z = pleat_depth sin(2 pi pleats x / width), so the cloth itself is wider than `width`.

    Parameters
    ----------
    n : int
        The number of quads along x, at least 4 per pleat.
    m : int
        The number of quads from top to bottom, at least 1.
    width : float
        The distance between its sides, in metres.
    height : float
        In metres.
    pleats : int
        The number of pleats, at least 0.
    pleat_depth : float
        How far pleats reach from the xy-plane, to the front and to the back, in metres.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n must be at least 32, got 20".
    """
    pleats = as_count(pleats, "pleats", 0)
    n, m = as_count(n, "n", max(1, 4 * pleats)), as_count(m, "m", 1)
    _require_room((n + 1) * (m + 1), "n")
    width, height = as_length(width, "width"), as_length(height, "height")
    pleat_depth = as_length(pleat_depth, "pleat_depth")
    y, x = np.meshgrid(np.linspace(0.0, -height, m + 1), _spread(n, width), indexing="ij")
    phase = np.broadcast_to(np.linspace(0.0, math.tau * pleats, n + 1), x.shape)
    return _join_rows(np.stack([x, y, pleat_depth * np.sin(phase)], axis=-1), is_downwards=True)


def hair(
    strands: int,
    points: int,
    *,
    radius: float = 0.1,
    length: float = 0.25,
    angle: float = 100.0,
    curls: float = 0.0,
    curl_radius: float = 0.01,
) -> Strands:
    """Return hair that stands up from a sphere about the origin, in the directions of a spiral around +y.

    Parameters
    ----------
    strands : int
        The number of strands, at least 1.
    points : int
        The number of points of each, at least 2.
    radius : float
        Of the sphere, in metres.
    length : float
        Of the strands without their curls, in metres.
    angle : float
        Up to how many degrees from +y roots lie, from 0 to 180.
    curls : float
        How many turns each strand makes around its direction; 0 for straight hair.
    curl_radius : float
        Of the helix of a curl, in metres; it is reached after the first quarter of the strand.

    Returns
    -------
    Strands

    Raises
    ------
    ArgumentError
        "strands must be at least 1, got 0".

    Notes
    -----
    The spiral of Fibonacci: R. Swinbank and R. J. Purser, Quarterly Journal of the Royal Meteorological Society 132,
    2006.
    """
    strands, points = as_count(strands, "strands", 1), as_count(points, "points", 2)
    _require_room(strands * points, "strands")
    radius, length, curl_radius = (
        as_length(value, name) for value, name in ((radius, "radius"), (length, "length"), (curl_radius, "curl_radius"))
    )
    angle, curls = as_float(angle, "angle"), as_float(curls, "curls")
    if not 0.0 < angle <= 180.0:
        raise ArgumentError.expecting("angle", "lie above 0, up to 180 degrees", f"{angle:g}")
    if curls < 0.0:
        raise ArgumentError.expecting("curls", "not be negative", f"{curls:g}")
    number = np.arange(strands) + 0.5
    y = 1.0 - (1.0 - math.cos(math.radians(angle))) * number / strands
    around = number * (math.tau / PHI)
    across = np.sqrt(1.0 - y * y)
    direction = np.stack([across * np.cos(around), y, across * np.sin(around)], axis=1)
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction), axis=1)])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(direction, side)
    along = np.linspace(0.0, 1.0, points)
    curves = (radius + length * along)[np.newaxis, :, np.newaxis] * direction[:, np.newaxis]
    if curls:
        turned, reach = math.tau * curls * along, curl_radius * np.minimum(4.0 * along, 1.0)
        curves += (reach * (np.cos(turned) - 1.0))[:, np.newaxis] * side[:, np.newaxis]
        curves += (reach * np.sin(turned))[:, np.newaxis] * other[:, np.newaxis]
    return Strands(curves, points_per_turn=round((points - 1) / curls) if curls else 0)


def _join_rows(rows: Float64Array, *, is_downwards: bool = False) -> Mesh:
    """Return the quads between rows of points (m, n, 3), which follow one another upwards as seen from the front."""
    m, n, _ = rows.shape
    corner = np.arange(m * n).reshape(m, n)
    below, above = (corner[1:], corner[:-1]) if is_downwards else (corner[:-1], corner[1:])
    quads = np.stack([below[:, :-1], below[:, 1:], above[:, 1:], above[:, :-1]], axis=-1)
    return Mesh(rows.reshape(-1, 3), quads.reshape(-1, 4))


def _spread(n: int, length: float) -> Float64Array:
    """Return n + 1 numbers from -length / 2 to length / 2."""
    return np.linspace(-length / 2.0, length / 2.0, n + 1)


def _require_room(n_points: int, name: str) -> None:
    """Raise ArgumentError for more points than a model to simulate can have."""
    if n_points > _MAX_SPRING_POINTS:
        raise ArgumentError.expecting(name, f"make at most {_MAX_SPRING_POINTS:,} points", f"{n_points:,}")
