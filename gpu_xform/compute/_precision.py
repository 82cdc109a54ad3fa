"""Precision: the number type in which a transform is computed, and a warning where single precision is too coarse."""

import warnings
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from .._core.memmap import release_pages
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..device import Device
from ..errors import ArgumentError, PrecisionError, PrecisionWarning

Precision = Literal["auto", "float32", "float64", "rebased"]

# Fewer steps than this across a model show in a picture of it, and in most measurements.
MIN_STEPS_PER_EXTENT = 4096
MAX_SAMPLED_POINTS = 1024
# What they are of a coordinate: float32 resolves at most 2^-23 of it; twice that is on the safe side of a sum.
MIN_EXTENT_PER_COORDINATE = MIN_STEPS_PER_EXTENT * 2.0**-22

SINGLE: np.dtype[Any] = np.dtype(np.float32)
DOUBLE: np.dtype[Any] = np.dtype(np.float64)


@dataclass(frozen=True)
class Computation:
    """The number type on the device, and whether points go there as offsets from origins that the host keeps."""

    dtype: np.dtype[Any]
    rebased: bool = False


def require_precision(precision: Precision) -> None:
    """Raise ArgumentError for a word that names no precision."""
    if precision not in get_args(Precision):
        hint = did_you_mean(str(precision), get_args(Precision))
        expected = f"be one of {', '.join(get_args(Precision))}"
        raise ArgumentError.expecting("precision", expected, f"{precision!r}{hint}")


def resolve_precision(precision: Precision, dtype: np.dtype[Any], device: Device) -> Computation:
    """Return how points of `dtype` are computed on `device`; raise `PrecisionError` if it cannot be done."""
    if precision == "auto":
        if dtype.itemsize == SINGLE.itemsize:
            return Computation(SINGLE)
        return Computation(DOUBLE) if device.has_float64 else Computation(SINGLE, rebased=True)
    if precision == "float64":
        if not device.has_float64:
            raise PrecisionError(
                f"{device.name!r} has no double precision (shader-f64): use precision='rebased' or 'float32'"
            )
        return Computation(DOUBLE)
    return Computation(SINGLE, rebased=precision == "rebased")


def require_range(matrices: Float64Array, dtype: np.dtype[Any]) -> None:
    """Raise `ArgumentError` if an entry of `matrices` is too large for `dtype`."""
    largest = np.abs(matrices).max(initial=0.0)
    if largest > np.finfo(dtype).max:
        raise ArgumentError.expecting("matrix", f"fit {dtype}", f"an entry of {largest:g}")


_warned = False


def rounds_to_float32(precision: Precision, points: npt.NDArray[Any]) -> bool:
    """Say whether the coordinates themselves are rounded to float32."""
    return precision == "float32" or (points.dtype.itemsize == SINGLE.itemsize and precision == "auto")


def warn_if_coarse(points: npt.NDArray[Any]) -> None:
    """Warn, once per process, if single precision has too few steps across the extent of `points` (..., n, 2 or 3).

    Judged by about a thousand points of the first set, evenly spaced.
    """
    global _warned
    if _warned or points.size == 0:
        return
    first = points[(0,) * (points.ndim - 2)]
    if not may_be_coarse(first[0].tolist(), first[-1].tolist()):  # the usual case, much faster than a sample
        return
    sample = first[:: max(1, len(first) // MAX_SAMPLED_POINTS)]
    low, high = sample.min(axis=0), sample.max(axis=0)
    release_pages(first)
    with np.errstate(over="ignore", invalid="ignore"):
        extent = float((high - low).max())
        step = float(np.spacing(np.float32(max(np.abs(low).max(), np.abs(high).max()))))
    if 0.0 < extent < step * MIN_STEPS_PER_EXTENT:
        _warned = True
        warnings.warn(
            f"float32 resolves these coordinates to {step:g} only, across an extent of {extent:g}: "
            "pass float64 points, or subtract an origin first",
            PrecisionWarning,
            stacklevel=3,
        )


def may_be_coarse(first: list[float], last: list[float]) -> bool:
    """Say whether float32 may have too few steps across points of which these are two.

    The extent is at least what lies between the two, and no coordinate is larger than that of one and the extent.
    """
    largest = 0.0
    for a in first:  # plain loops: `max` and `any` take twice as long, which shows in calls on few points
        largest = abs(a) if not abs(a) <= largest else largest
    limit = largest * MIN_EXTENT_PER_COORDINATE
    for a, b in zip(first, last):  # noqa: B905, SIM110
        if abs(a - b) > limit:
            return False
    return True
