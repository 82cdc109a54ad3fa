import dataclasses
import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import settings

from gpu_xform.gpu import device as device_module
from gpu_xform.gpu.device import Device, default_device

settings.register_profile("local", deadline=None, max_examples=60, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("local"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


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
