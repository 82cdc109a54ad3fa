"""What drivers compute differently: in no promise of ours, or computed on the host. It holds on every driver.

Mesa 22.3 and 25.0 and SwiftShader sum in other orders, flush numbers below the smallest normal one or do not, divide by
literals through reciprocals, and are off by up to 4e-4 in powers, sines and their kin.
"""

import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.gpu.device import GpuDevice
from tests.support.wgsl import FOLDER

TEXTS = {path.relative_to(FOLDER).as_posix(): path.read_text("utf-8") for path in sorted(FOLDER.rglob("*.wgsl"))}
INEXACT = (
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "cosh",
    "exp",
    "exp2",
    "log",
    "log2",
    "pow",
    "sin",
    "sinh",
    "tan",
    "tanh",
)
# Where such a number is no more than a part of a step of eight bits.
ALLOWED_CALLS = {("shared/absorbance.wgsl", "exp"), ("shared/absorbance.wgsl", "log")}
# Rounded to whole multiples at once; a threshold far from what it is compared with; an opacity, which becomes a byte;
# the mean velocity of a triangle in the wind, whose last bit no promise holds.
ALLOWED_DIVISORS = {
    ("shared/destination.wgsl", "255.0"),
    ("shared/aliased_fragment.wgsl", "255.0"),
    ("raster/splat_points.wgsl", "255.0"),
    ("simulation/step_springs.wgsl", "3.0"),
}


def code_of(name: str) -> str:
    """Return a file of WGSL without its comments."""
    return re.sub(r"//.*", "", TEXTS[name])


def test_shaders_call_no_function_that_drivers_approximate() -> None:
    for name in TEXTS:
        calls = re.findall(rf"(?<![\w.])({'|'.join(INEXACT)})\(", code_of(name))
        assert {(name, call) for call in calls} <= ALLOWED_CALLS, name


def test_shaders_divide_by_no_literal() -> None:
    for name in TEXTS:
        divisors = re.findall(r"/=? *(\d+\.\d*|\d+f\b|\.\d+)", code_of(name))
        assert {(name, divisor) for divisor in divisors} <= ALLOWED_DIVISORS, name


@given(st.integers(0, 2**32 - 1), st.floats(-18, 6))
def test_sums_are_within_their_bound_in_whatever_order(device: GpuDevice, seed: int, exponent: float) -> None:
    """Large terms that cancel, beside small ones; and products below the smallest normal number, which may be 0."""
    rng = np.random.default_rng(seed)
    points = (rng.normal(size=(9, 3)) * 10.0**exponent).astype(np.float32)
    matrix = np.eye(4)
    matrix[:3, :3] = rng.normal(size=(3, 3)) * 10.0**exponent
    matrix[:3, 1] = -matrix[:3, 0] * (1 + 1e-6)
    matrix[:3, 3] = rng.normal(size=3) * 10.0 ** (2 * exponent)
    used = matrix.astype(np.float32).astype(np.float64)
    points[:, 1] = points[:, 0]
    exact = points.astype(np.float64) @ used[:3, :3].T + used[:3, 3]
    size = np.abs(points.astype(np.float64)) @ np.abs(used[:3, :3]).T + np.abs(used[:3, 3])
    result = gx.transform_points(points, matrix, device=device)
    assert (np.abs(result - exact) <= 5 * 2.0**-24 * size + 4 * np.finfo(np.float32).tiny).all()
