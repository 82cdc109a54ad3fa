"""Every test of this folder runs twice, on the default device and on the host device, but for those of one of them."""

from pathlib import Path

import pytest

import gpu_xform as gx
from gpu_xform import device as device_module
from gpu_xform.device import Device

ADAPTER_FIXTURES = {"device", "device_with_limits", "single_device", "staging_device"}
ADAPTER_MODULES = {"test_children.py", "test_grid.py"}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "process_device" in metafunc.fixturenames:
        path = metafunc.definition.path
        is_for_one = (
            path.parent != Path(__file__).parent
            or path.name in ADAPTER_MODULES
            or ADAPTER_FIXTURES & set(metafunc.fixturenames)
            or metafunc.definition.get_closest_marker("adapter")
        )
        metafunc.parametrize("process_device", ["adapter"] if is_for_one else ["adapter", "host"], indirect=True)


@pytest.fixture(scope="session")
def host() -> Device:
    """The host device."""
    return gx.Device("host")


@pytest.fixture(autouse=True)
def process_device(request: pytest.FixtureRequest, host: Device, monkeypatch: pytest.MonkeyPatch) -> Device:
    """The process's own device, which functions use by default."""
    if request.param == "host":
        monkeypatch.setattr(device_module, "_default", host)
    return gx.default_device()
