import dataclasses
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import settings

from gpu_xform.gpu import device as device_module
from gpu_xform.gpu.device import Device, default_device
from tests.support.browser import Browser
from tests.support.goldens import FOLDER, Goldens, Pixels, driver_of
from tests.support.xvfb import Screen

Array = npt.NDArray[np.float64]
CapsuleAreas = Callable[[Array, Array, float, tuple[int, int]], Array]

# What is started in the background may ignore Ctrl+C, and so does all that it starts; the tests interrupt both.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("local", deadline=None, max_examples=60, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("local"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-goldens", action="store_true", help="write the golden pictures that differ, and fail")


@pytest.fixture
def assert_golden(request: pytest.FixtureRequest, device: Device, tmp_path: Path) -> Callable[[Pixels, str], None]:
    """Hold a picture against the one kept under a name; `goldens` says how exactly."""
    update = request.config.getoption("--update-goldens")
    return Goldens(FOLDER, driver_of(device.adapter), tmp_path, update).check


@pytest.fixture(scope="session")
def device() -> Device:
    """The default device. A machine without one cannot say anything about this library: that is a failure."""
    return default_device()


@pytest.fixture(scope="session")
def limited(device: Device) -> Iterator[Callable[..., Device]]:
    """Make a device that plans by smaller limits: `limited(max_binding_bytes=65536)`."""
    made: dict[tuple[tuple[str, int], ...], Device] = {}

    def make(**limits: int) -> Device:
        key = tuple(sorted(limits.items()))
        if key not in made:
            made[key] = Device(limits=dataclasses.replace(device.limits, **limits))
        return made[key]

    yield make
    for other in made.values():
        other.close()


@pytest.fixture(scope="session")
def staging_device() -> Iterator[Device]:
    """A device whose memory the host cannot map, as on a discrete GPU."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(device_module, "HOST_MAPPABLE_KINDS", frozenset[Any]())
        staging = Device()
    assert not staging.host_mappable
    with staging:
        yield staging


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A headless Chromium, started by the first test that asks for it. A machine without one is a failure."""
    with Browser() as shown:
        yield shown


@pytest.fixture(scope="session")
def screen() -> Iterator[Screen]:
    """A screen for windows, started by the first test that asks for it. A machine without one is a failure."""
    with Screen() as lit:
        yield lit


@pytest.fixture(scope="session")
def capsule_areas() -> CapsuleAreas:
    """How much of every pixel lies under a line with round ends: (height, width) float64.

    The line goes from `a` to `b`, in pixels from the top left corner. Every row is cut into 64; the capsule is convex,
    so that each cut goes through it in one piece, whose ends are exact.
    """

    def areas(a: Array, b: Array, line_width: float, size: tuple[int, int]) -> Array:
        width, height = size
        radius = 0.5 * line_width
        y = (np.arange(64 * height) + 0.5) / 64
        left, right = np.full(len(y), np.inf), np.full(len(y), -np.inf)
        for center in (a, b):
            square = radius**2 - (y - center[1]) ** 2
            half = np.sqrt(np.maximum(square, 0.0))
            left = np.where(square >= 0.0, np.minimum(left, center[0] - half), left)
            right = np.where(square >= 0.0, np.maximum(right, center[0] + half), right)
        length = float(np.hypot(*(b - a)))
        if length > 0.0:
            across = radius / length * np.array([a[1] - b[1], b[0] - a[0]])
            corners = [a + across, b + across, b - across, a - across]
            for p, q in zip(corners, corners[1:] + corners[:1], strict=True):
                if p[1] == q[1]:
                    continue
                t = (y - p[1]) / (q[1] - p[1])
                x = p[0] + t * (q[0] - p[0])
                inside = (t >= 0.0) & (t <= 1.0)
                left = np.where(inside, np.minimum(left, x), left)
                right = np.where(inside, np.maximum(right, x), right)
        pixel = np.arange(width)
        covered = np.clip(np.minimum(right[:, None], pixel + 1) - np.maximum(left[:, None], pixel), 0.0, 1.0)
        result: Array = covered.reshape(height, 64, width).mean(axis=1)
        return result

    return areas
