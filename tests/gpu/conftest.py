import pytest

from gpu_xform.gpu.device import Device


@pytest.fixture(params=["default", "staging"])
def any_device(request: pytest.FixtureRequest, device: Device, staging_device: Device) -> Device:
    """The default device, and one whose memory the host cannot map."""
    return device if request.param == "default" else staging_device
