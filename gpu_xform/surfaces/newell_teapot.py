"""Newell's teapot as 32 bicubic patches, from its profiles and sections.

Martin Newell drew the teapot in 1975 ("The utilization of procedure models in digital image synthesis", University of
Utah). These numbers are his as they are used everywhere, with the heights that James Blinn scaled down ("What, Teapots
Again?", IEEE Computer Graphics and Applications, September 1987): z is up, the body has the radius 2, and the bottom,
which was added later, at z = 0.

All patches but the handle's and the spout's are quarters of surfaces of revolution: a profile, four pairs of a radius
and a height, is carried along four control points that approximate a quarter of the unit circle: (1, 0), (1, kappa),
(kappa, 1), (0, 1). Newell took 0.56 for kappa, not 4/3 (sqrt(2) - 1) = 0.5523. Handle and spout are half tubes along
four sections, mirrored in the plane y = 0.
"""

from collections.abc import Sequence

import numpy as np

from .._core.types import Float64Array
from .bernstein import evaluate_bernstein

_Profile = Sequence[tuple[float, float]]
_Section = tuple[tuple[float, float], tuple[float, float], float]

_KAPPA = 0.56
_KNOB_KAPPA = 0.5625  # of the knob's second ring alone: Newell's 0.45 at a radius of 0.8
_N_DECIMALS = 9  # products such as 1.5 * 0.56 become Newell's decimals again

_RIM_PROFILE: _Profile = [(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)]
_BODY_PROFILES: tuple[_Profile, ...] = (
    [(1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)],
    [(2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)],
)
_KNOB_PROFILE: _Profile = [(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)]
_LID_PROFILE: _Profile = [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)]
_BOTTOM_PROFILE: _Profile = [(0.0, 0.0), (1.425, 0.0), (1.5, 0.075), (1.5, 0.15)]

# Sections of tubes: the inner end (x, z), the outer end (x, z), and half the width.
_HANDLE_SECTIONS: tuple[Sequence[_Section], ...] = (
    [
        ((-1.6, 2.025), (-1.5, 2.25), 0.3),
        ((-2.3, 2.025), (-2.5, 2.25), 0.3),
        ((-2.7, 2.025), (-3.0, 2.25), 0.3),
        ((-2.7, 1.8), (-3.0, 1.8), 0.3),
    ],
    [
        ((-2.7, 1.8), (-3.0, 1.8), 0.3),
        ((-2.7, 1.575), (-3.0, 1.35), 0.3),
        ((-2.5, 1.125), (-2.65, 0.9375), 0.3),
        ((-2.0, 0.9), (-1.9, 0.6), 0.3),
    ],
)
_SPOUT_SECTIONS: tuple[Sequence[_Section], ...] = (
    [
        ((1.7, 1.425), (1.7, 0.6), 0.66),
        ((2.6, 1.425), (3.1, 0.825), 0.66),
        ((2.3, 2.1), (2.4, 2.025), 0.25),
        ((2.7, 2.4), (3.3, 2.4), 0.25),
    ],
    [
        ((2.7, 2.4), (3.3, 2.4), 0.25),
        ((2.8, 2.475), (3.525, 2.49375), 0.25),
        ((2.9, 2.475), (3.45, 2.5125), 0.15),
        ((2.8, 2.4), (3.2, 2.4), 0.15),
    ],
)


def make_teapot_patches(*, bottom: bool, fit_lid: bool) -> Float64Array:
    """Return the control points (k, 4, 4, 3): 32 patches, 28 without the bottom.

    dS/du x dS/dv points outwards. In the usual file it points inwards, but for the bottom.

    fit_lid : whether to widen the lid, so that it touches the rim
    """
    widening = _find_rim_opening() / _find_lid_radius() if fit_lid else 1.0
    rings = [_revolve(_RIM_PROFILE), *map(_revolve, _BODY_PROFILES)]
    lid = [_revolve(_KNOB_PROFILE, (_KAPPA, _KNOB_KAPPA, _KAPPA, _KAPPA)), _revolve(_LID_PROFILE)]
    tubes = [_mirror(sections) for sections in (*_HANDLE_SECTIONS, *_SPOUT_SECTIONS)]
    patches = np.concatenate([*rings, *tubes, *(ring * [widening, widening, 1.0] for ring in lid)])
    if bottom:  # runs outwards as the lid does, and faces down
        patches = np.concatenate([patches, _revolve(_BOTTOM_PROFILE).swapaxes(1, 2)])
    return np.round(patches, _N_DECIMALS) + 0.0  # -0 becomes 0


def _revolve(profile: _Profile, kappas: Sequence[float] = (_KAPPA,) * 4) -> Float64Array:
    """Return four quarters (4, 4, 4, 3) of the surface of revolution about z, counter-clockwise as seen from above."""
    radius, height = np.array(profile).T
    kappa = np.array(kappas)
    one, none = np.ones(4), np.zeros(4)
    along = np.stack([np.stack([one, one, kappa, none], 1), np.stack([none, kappa, one, one], 1)], -1)
    quarter = along * radius[:, np.newaxis, np.newaxis]
    patches = np.empty((4, 4, 4, 3))
    for q in range(4):
        patches[q, ..., :2] = quarter @ _QUARTERS[q]
    patches[..., 2] = height[:, np.newaxis]
    return patches


# Row vectors: what (1, 0) and (0, 1) of a quarter become; one quarter follows the other.
_QUARTERS = np.array([[(0, 1), (-1, 0)], [(-1, 0), (0, -1)], [(0, -1), (1, 0)], [(1, 0), (0, 1)]], np.float64)


def _mirror(sections: Sequence[_Section]) -> Float64Array:
    """Return a half tube along four sections, and its mirror image in the plane y = 0: (2, 4, 4, 3)."""
    half = np.array(
        [[(x1, 0.0, z1), (x1, -width, z1), (x0, -width, z0), (x0, 0.0, z0)] for (x0, z0), (x1, z1), width in sections]
    )
    return np.stack([half, half[:, ::-1] * [1.0, -1.0, 1.0]])


def _find_rim_opening() -> float:
    """Return the least radius of the rim: 1.380."""
    return float(_sample_radius(_RIM_PROFILE).min())


def _find_lid_radius() -> float:
    """Return the largest radius of the lid: 1.305."""
    return float(_sample_radius(_LID_PROFILE).max())


def _sample_radius(profile: _Profile) -> Float64Array:
    """Return the radii of a profile at its ends and where its derivative vanishes."""
    radius = np.array(profile)[:, 0]
    a, b, c = np.diff(radius) * [1.0, 2.0, 1.0]
    roots = np.roots([a - b + c, b - 2.0 * a, a])
    inside = roots.real[(np.abs(roots.imag) < 1e-12) & (roots.real > 0) & (roots.real < 1)]
    radii: Float64Array = evaluate_bernstein(3, np.concatenate([[0.0, 1.0], inside])) @ radius
    return radii
