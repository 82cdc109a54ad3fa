"""Sample models for pictures and tests: meshes computed from their geometry, and a scene of meshes.

All faces are counter-clockwise as seen from outside, if there is an outside.
"""

import math
from collections.abc import Sequence
from typing import SupportsIndex

import numpy as np
import numpy.typing as npt

from ._core.arguments import as_float, as_int
from ._core.types import Float64Array, IndexArray
from .errors import ArgumentError
from .geometry.mesh import Mesh
from .geometry.scene import Scene
from .geometry.strands import Strands
from .matrices import rotate, translate
from .surfaces.function_surfaces import parametric
from .surfaces.newell_teapot import make_teapot_patches
from .surfaces.patches import bezier

__all__ = [
    "cloth",
    "cube",
    "curtain",
    "grid",
    "hair",
    "house",
    "icosphere",
    "klein_bottle",
    "moebius",
    "robot_arm",
    "saddle",
    "snub_dodecahedron",
    "teapot",
    "teapot_patches",
    "torus",
    "trefoil_tube",
]

_PHI = (1.0 + math.sqrt(5.0)) / 2.0
_MAX_SUBDIVISIONS = 12  # 3.4e8 triangles, 16 GB
_MAX_SPRING_POINTS = 1 << 27  # of a cloth or of hair: 3 GB


def __dir__() -> list[str]:
    return __all__


def cube() -> Mesh:
    """Return the cube [-1, 1]^3: 8 points, 6 quads.

    Returns
    -------
    Mesh
    """
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    return Mesh(corners, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])


def house() -> Mesh:
    """Return a house in [-1, 1]^3 with a gable roof along z: 10 points, 5 quads, and a pentagon at the front and back.

    y points up, and the front is at z = 1.

    Returns
    -------
    Mesh
    """
    return _make_prism([(-1.0, -1.0), (1.0, -1.0), (1.0, 0.25), (0.0, 1.0), (-1.0, 0.25)], -1.0, 1.0)


def snub_dodecahedron() -> Mesh:
    """Return the snub dodecahedron with edges of length 1: 60 points, 150 edges, 80 triangles and 12 pentagons.

    The points are the images of one point under the 60 rotations of the icosahedron. With xi the real root of
    xi^3 - 2 xi = phi, that point is (2 alpha, 2, 2 beta), alpha = xi - 1/xi, beta = xi phi + phi^2 + phi/xi.

    Returns
    -------
    Mesh
    """
    # Cardano's formula for x^3 = 2 x + phi.
    root = math.sqrt((_PHI / 2.0) ** 2 - (2.0 / 3.0) ** 3)
    xi = math.cbrt(_PHI / 2.0 + root) + math.cbrt(_PHI / 2.0 - root)
    seed = np.array([2.0 * (xi - 1.0 / xi), 2.0, 2.0 * (xi * _PHI + _PHI**2 + _PHI / xi)])
    return _make_convex(_generate_icosahedral_rotations() @ seed)


def icosphere(n: int) -> Mesh:
    """Return the unit sphere as a subdivided icosahedron: 10 * 4^n + 2 points, 20 * 4^n triangles.

    Parameters
    ----------
    n : int
        The number of subdivisions, 0..12.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n must be in 0..12, got 13".
    """
    n = _as_count(n, "n", 0, _MAX_SUBDIVISIONS)
    signs = [(a, b) for a in (-_PHI, _PHI) for b in (-1.0, 1.0)]
    ico = _make_convex(np.array([np.roll((0.0, a, b), shift) for shift in range(3) for a, b in signs]))
    points = ico.positions / np.linalg.norm(ico.positions, axis=1, keepdims=True)
    triangles = np.asarray(ico.faces)
    for _ in range(n):
        points, triangles = _subdivide(points, triangles)
    return Mesh(points, triangles)


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
    n = _as_count(n, "n", 1)
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
    n, m = _as_count(n, "n", 1), _as_count(m, "m", 1)
    _require_room((n + 1) * (m + 1), "n")
    width, depth = _as_length(width, "width"), _as_length(depth, "depth")
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
    pleats = _as_count(pleats, "pleats", 0)
    n, m = _as_count(n, "n", max(1, 4 * pleats)), _as_count(m, "m", 1)
    _require_room((n + 1) * (m + 1), "n")
    width, height = _as_length(width, "width"), _as_length(height, "height")
    pleat_depth = _as_length(pleat_depth, "pleat_depth")
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
    strands, points = _as_count(strands, "strands", 1), _as_count(points, "points", 2)
    _require_room(strands * points, "strands")
    radius, length, curl_radius = (
        _as_length(value, name)
        for value, name in ((radius, "radius"), (length, "length"), (curl_radius, "curl_radius"))
    )
    angle, curls = as_float(angle, "angle"), as_float(curls, "curls")
    if not 0.0 < angle <= 180.0:
        raise ArgumentError.expecting("angle", "lie above 0, up to 180 degrees", f"{angle:g}")
    if curls < 0.0:
        raise ArgumentError.expecting("curls", "not be negative", f"{curls:g}")
    number = np.arange(strands) + 0.5
    y = 1.0 - (1.0 - math.cos(math.radians(angle))) * number / strands
    around = number * (math.tau / _PHI)
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


def torus(n: int, m: int) -> Mesh:
    """Return a torus about the z-axis of ring radius 1 and tube radius 0.4: n * m points and quads.

    Parameters
    ----------
    n : int
        The number of quads around the ring, at least 3.
    m : int
        The number of quads around the tube, at least 3.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n must be at least 3, got 2".
    """
    n, m = _as_count(n, "n", 3), _as_count(m, "m", 3)
    ring, tube = np.meshgrid(np.arange(n) * (2 * np.pi / n), np.arange(m) * (2 * np.pi / m), indexing="ij")
    radius = 1.0 + 0.4 * np.cos(tube)
    points = np.stack([radius * np.cos(ring), radius * np.sin(ring), 0.4 * np.sin(tube)], axis=-1)
    corner = np.arange(n * m).reshape(n, m)
    along, around = np.roll(corner, -1, axis=0), np.roll(corner, -1, axis=1)
    quads = np.stack([corner, along, np.roll(along, -1, axis=1), around], axis=-1)
    return Mesh(points.reshape(-1, 3), quads.reshape(-1, 4))


def teapot(n: SupportsIndex = 8, bottom: bool = True, fit_lid: bool = False) -> Mesh:
    """Return the Utah teapot, 32 Bézier patches of n x n quads each: 1,984 quads and 64 triangles for n = 8.

    Its axis is y, and its spout points along x. The body has the radius 2, and its bottom lies at y = 0, the top of the
    lid at 3.15. As the original it has six open borders: the rim, the lid, and both ends of the handle and of the
    spout. The opening of the rim has the radius 1.380, the lid only 1.305. The lower end of the handle and the body
    have one control point in common, and so one point.

    Parameters
    ----------
    n : int
        The number of steps along each side of each patch, at least 1.
    bottom : bool
        Whether there is a bottom. The original has none; it was added later, is not quite flat, and is wound the other
        way in the usual file. Here it faces outwards.
    fit_lid : bool
        Whether to widen the lid by the factor 1.062, so that it touches the rim.

    Returns
    -------
    Mesh
        With "normal" per corner, as `bezier` returns it.

    Raises
    ------
    ArgumentError
        "n must be at least 1, got 0".

    Notes
    -----
    Source: M. Newell, "The utilization of procedure models in digital image synthesis", University of Utah, 1975. The
    heights are those that J. Blinn scaled down, as in all copies of the numbers. They follow from six profiles, the
    sections of handle and spout, and Newell's 0.56 for control points that approximate a quarter of a circle.
    """
    return bezier(teapot_patches(bottom, fit_lid), n)


def teapot_patches(bottom: bool = True, fit_lid: bool = False) -> Float64Array:
    """Return the control points of the teapot's 32 bicubic patches, for `bezier` with a tolerance.

    Parameters
    ----------
    bottom, fit_lid : bool
        As `teapot` takes them; without its bottom it has 28 patches.

    Returns
    -------
    (k, 4, 4, 3) float64
        290 of them are different.
    """
    x, y, z = np.moveaxis(make_teapot_patches(bottom=bottom, fit_lid=fit_lid), -1, 0)
    return np.stack([x, z, 0.0 - y], axis=-1)


def saddle(n: SupportsIndex) -> Mesh:
    """Return the saddle z = x^2 - y^2 over [-1, 1]^2 as n x n quads that face +z: (n + 1)^2 points.

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
    return parametric(lambda x, y: (x, y, x * x - y * y), (-1, 1), (-1, 1), closed=(False, False), n=n)


def moebius(n: SupportsIndex, m: SupportsIndex) -> Mesh:
    """Return a Möbius strip about the z-axis of radius 1 and width 0.8: n * (m + 1) points, n * m quads.

    It has one side and one border. The first quads run the other way round than the last ones, their neighbours.

    Parameters
    ----------
    n : int
        The number of quads around, at least 3.
    m : int
        The number of quads across, at least 1.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n[0] must be at least 3, got 2".
    """

    def f(u: Float64Array, v: Float64Array) -> tuple[Float64Array, ...]:
        radius = 1.0 + v * np.cos(0.5 * u)
        return radius * np.cos(u), radius * np.sin(u), v * np.sin(0.5 * u)

    return parametric(f, (0, math.tau), (-0.4, 0.4), closed=(True, False), n=(n, m))


def klein_bottle(n: SupportsIndex, m: SupportsIndex) -> Mesh:
    """Return a Klein bottle, which stands along y and passes through itself: n * m points and quads.

    It is closed and has one side. The first rings of quads run the other way round than the last ones, their
    neighbours.

    Parameters
    ----------
    n : int
        The number of quads along the bottle, at least 3.
    m : int
        The number of quads around it, even and at least 4.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "m must be even and at least 4, got 3".

    Notes
    -----
    Source of the polynomials: R. Israel, "Klein bottle", Maple Application Center, 2003.
    """
    count = _as_count(m, "m", 1)
    if count < 4 or count % 2:  # the ends meet half a turn apart
        raise ArgumentError.expecting("m", "be even and at least 4", count)

    def f(u: Float64Array, v: Float64Array) -> tuple[Float64Array, ...]:
        s, c, t = np.sin(u), np.cos(u), np.cos(v)
        x = -c * (3 * t - 30 * s + 90 * c**4 * s - 60 * c**6 * s + 5 * c * t * s) * (2 / 15)
        y = 3 * t - 3 * c**2 * t - 48 * c**4 * t + 48 * c**6 * t - 60 * s
        y = y + 5 * c * t * s - 5 * c**3 * t * s - 80 * c**5 * t * s + 80 * c**7 * t * s
        return x, -s * y / 15, (2 / 15) * (3 + 5 * c * s) * np.sin(v)

    return parametric(f, (0, math.pi), (0, math.tau), closed=(True, True), n=(n, count))


def trefoil_tube(n: SupportsIndex, m: SupportsIndex) -> Mesh:
    """Return a tube of radius 0.5 around the trefoil knot, which lies about the z-axis: n * m points and quads.

    The knot is (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t).

    Parameters
    ----------
    n : int
        The number of quads along the knot, at least 3.
    m : int
        The number of quads around the tube, at least 3.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n[0] must be at least 3, got 2".
    """

    def f(t: Float64Array, v: Float64Array) -> Float64Array:
        knot = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
        first = np.stack([np.cos(t) + 4 * np.cos(2 * t), -np.sin(t) + 4 * np.sin(2 * t), -3 * np.cos(3 * t)])
        second = np.stack([-np.sin(t) - 8 * np.sin(2 * t), -np.cos(t) + 8 * np.cos(2 * t), 9 * np.sin(3 * t)])
        binormal = np.cross(first, second, axis=0)  # nowhere zero: the knot bends everywhere
        binormal /= np.linalg.norm(binormal, axis=0)
        normal = np.cross(binormal, first, axis=0) / np.linalg.norm(first, axis=0)
        tube: Float64Array = knot + 0.5 * (np.cos(v) * normal - np.sin(v) * binormal)
        return tube

    return parametric(f, (0, math.tau), (0, math.tau), closed=(True, True), n=(n, m))


def robot_arm() -> Scene:
    """Return a robot arm that stands on the xz-plane, straight up along y.

    "base" is the parent of "upper arm", that of "forearm", and that of "hand". Each part rotates about the z-axis of
    its own frame: `arm["forearm"].transform @ rotate_z(angle)` bends the elbow. The shoulder is at y = 0.9, the elbow
    at 2.9, the wrist at 4.5.

    Returns
    -------
    Scene
    """
    half_turn = np.linspace(0.0, math.pi, 7)
    above = 0.3 * np.column_stack([np.cos(half_turn), np.sin(half_turn)])
    below = -above
    # Each moving part lies between two plates of its parent.
    inside, plates = (-0.14, 0.14), ((-0.3, -0.16), (0.16, 0.3))
    arm = Scene()
    base = arm.add(_make_prism([(-1.0, 0.0), (1.0, 0.0), (1.0, 0.3), (-1.0, 0.3)], -1.0, 1.0), name="base")
    for plate in plates:
        base.show(_make_prism([(-0.3, 0.3), (0.3, 0.3), *np.add(above, (0.0, 0.9))], *plate))
    upper_arm = arm.add(name="upper arm", parent=base, transform=translate(0.0, 0.9, 0.0))
    upper_arm.show(_make_prism([*below, *np.add(above, (0.0, 2.0))], *inside))
    forearm = arm.add(name="forearm", parent=upper_arm, transform=translate(0.0, 2.0, 0.0))
    for plate in plates:
        forearm.show(_make_prism([*below, *np.add(above, (0.0, 1.6))], *plate))
    hand = arm.add(name="hand", parent=forearm, transform=translate(0.0, 1.6, 0.0))
    right = [(0.3, 0.4), (0.45, 0.5), (0.45, 1.1), (0.3, 1.1), (0.3, 0.6)]
    hand.show(_make_prism([*below, *right, *((-x, y) for x, y in reversed(right))], *inside))
    return arm


def _make_prism(profile: Sequence[npt.ArrayLike], low: float, high: float) -> Mesh:
    """Return the prism from z = `low` to `high` whose ends are the polygon `profile` (n, 2), counter-clockwise."""
    n = len(profile)
    points = [(x, y, z) for z in (high, low) for x, y in np.asarray(profile)]
    sides = [(i, i + n, (i + 1) % n + n, (i + 1) % n) for i in range(n)]
    return Mesh(points, [range(n), range(2 * n - 1, n - 1, -1), *sides])


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


def _as_length(value: float, name: str) -> float:
    """Return `value` as a finite float above 0."""
    length = as_float(value, name)
    if length <= 0.0:
        raise ArgumentError.expecting(name, "be positive", f"{length:g}")
    return length


def _as_count(value: SupportsIndex, name: str, minimum: int, maximum: int | None = None) -> int:
    """Return `value` as an int from `minimum` to `maximum`."""
    count = as_int(value, name)
    if count < minimum or (maximum is not None and count > maximum):
        bounds = f"at least {minimum}" if maximum is None else f"in {minimum}..{maximum}"
        raise ArgumentError.expecting(name, f"be {bounds}", count)
    return count


def _require_room(n_points: int, name: str) -> None:
    """Raise ArgumentError for more points than a model to simulate can have."""
    if n_points > _MAX_SPRING_POINTS:
        raise ArgumentError.expecting(name, f"make at most {_MAX_SPRING_POINTS:,} points", f"{n_points:,}")


def _generate_icosahedral_rotations() -> Float64Array:
    """Return the rotations that map the icosahedron with corners (0, +-phi, +-1), ... onto itself: (60, 3, 3)."""
    # A fifth of a revolution about the corner (0, phi, 1), and a third about (1, 1, 1).
    fifth = rotate((0.0, _PHI, 1.0), math.tau / 5)[:3, :3]
    third = np.roll(np.eye(3), 1, axis=0)
    group = [np.eye(3)]
    for rotation in group:  # the list grows until it is closed under both generators
        for product in (fifth @ rotation, third @ rotation):
            if not any(np.abs(product - known).max() < 1e-9 for known in group):
                group.append(product)
    return np.array(group)


def _make_convex(points: Float64Array) -> Mesh:
    """Return the convex polyhedron around 0 with these points, scaled so that its edges, the least distances, are 1."""
    gaps = np.linalg.norm(points[:, None] - points[None, :], axis=2)
    np.fill_diagonal(gaps, np.inf)
    edge = gaps.min()
    # Of each point, counter-clockwise as seen from outside.
    neighbours: list[list[int]] = []
    for point, row in zip(points, gaps, strict=True):
        near = np.flatnonzero(row < edge * (1.0 + 1e-9))
        right = np.cross(point, points[near[0]])
        right /= np.linalg.norm(right)
        up = np.cross(point / np.linalg.norm(point), right)
        neighbours.append(near[np.argsort(np.arctan2(points[near] @ up, points[near] @ right))].tolist())
    # Follow each face with the outside on the left: from a to b, and then to the neighbour of b before a.
    faces, seen = [], set()
    for start in [(a, b) for a, around in enumerate(neighbours) for b in around]:
        face, (a, b) = [], start
        while (a, b) not in seen:
            seen.add((a, b))
            face.append(a)
            a, b = b, neighbours[b][neighbours[b].index(a) - 1]
        if face:
            faces.append(face)
    return Mesh(points / edge, faces)


def _subdivide(points: Float64Array, triangles: IndexArray) -> tuple[Float64Array, IndexArray]:
    """Divide each triangle of a closed mesh on the unit sphere into four."""
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    keys, which = np.unique(ends[..., 0] << 32 | ends[..., 1], return_inverse=True)
    midpoints = points[keys >> 32] + points[keys & 0xFFFFFFFF]
    midpoints /= np.linalg.norm(midpoints, axis=1, keepdims=True)
    a, b, c = triangles.T
    ab, bc, ca = (which.reshape(-1, 3) + len(points)).T
    fours = np.stack([a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca], axis=1).reshape(-1, 3)
    return np.concatenate([points, midpoints]), fours
