"""Comparison of pictures of black lines on white: whether they show the same lines."""

import itertools

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.uint8]

MAX_ASTRAY_PART = 1e-3
MAX_COVERAGE_RATIO = 1.5


def lit(picture: Pixels) -> npt.NDArray[np.bool_]:
    """Return which pixels are a tenth of the way from white to black, or farther."""
    return np.asarray(picture[..., :3].mean(axis=2) < 230)


def astray(picture: Pixels, other: Pixels) -> float:
    """Return the part of the lit pixels of `picture` that have no lit one of `other` within one pixel."""
    height, width = other.shape[:2]
    padded = np.pad(lit(other), 1)
    near = np.zeros((height, width), np.bool_)
    for y, x in itertools.product(range(3), repeat=2):
        near |= padded[y : y + height, x : x + width]
    return float(np.mean(~near[lit(picture)]))


def difference(ours: Pixels, theirs: Pixels, width_ratio: float = 1.0) -> str | None:
    """Return why two pictures do not show the same lines, as text; None if they do.

    width_ratio : the width of their lines over the width of ours
    """
    if theirs.shape[:2] != ours.shape[:2]:
        return f"it draws {theirs.shape[1]} x {theirs.shape[0]} pixels"
    if not (lit(ours).any() and lit(theirs).any()):
        return "nothing is drawn"
    lacking, added = astray(ours, theirs), astray(theirs, ours)
    if max(lacking, added) > MAX_ASTRAY_PART:
        return f"{100 * lacking:.2g} % of our lit pixels are far from theirs, {100 * added:.2g} % of theirs from ours"
    coverage = float((255.0 - theirs[..., :3]).sum() / (255.0 - ours[..., :3]).sum())
    if not 1 / MAX_COVERAGE_RATIO <= coverage / width_ratio <= MAX_COVERAGE_RATIO:
        return f"it covers {coverage:.2f} times as much as we do"
    return None


def n_shades(picture: Pixels) -> int:
    """Return the number of different greys: two if lines are not anti-aliased."""
    return len(np.unique(picture[..., :3].sum(axis=2, dtype=np.uint16)))
