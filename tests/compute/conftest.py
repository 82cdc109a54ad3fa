"""Every test of this folder, but for `host/`, that names no device runs on the default one and on the host device."""

from pathlib import Path

import pytest

import gpu_xform as gx
from gpu_xform import device as device_module
from gpu_xform.device import Device

ADAPTER_FIXTURES = {"device", "device_with_limits", "single_device", "staging_device"}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "process_device" in metafunc.fixturenames:
        is_own = metafunc.definition.path.parent == Path(__file__).parent / "host"
        is_for_one = is_own or ADAPTER_FIXTURES & set(metafunc.fixturenames)
        names = ["adapter"] if is_for_one else ["adapter", "host"]
        metafunc.parametrize("process_device", names, indirect=True)


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
