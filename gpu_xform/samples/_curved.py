"""Smooth surfaces as meshes: the torus, the teapot, and surfaces of functions."""

import math
from typing import SupportsIndex

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from ..surfaces.function_surfaces import parametric
from ..surfaces.newell_teapot import make_teapot_patches
from ..surfaces.patches import bezier
from ._arguments import as_count


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
    n, m = as_count(n, "n", 3), as_count(m, "m", 3)
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
    count = as_count(m, "m", 1)
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
