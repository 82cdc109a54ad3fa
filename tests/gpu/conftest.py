import pytest

from gpu_xform.gpu.device import GpuDevice


@pytest.fixture(params=["default", "staging"])
def any_device(request: pytest.FixtureRequest, device: GpuDevice, staging_device: GpuDevice) -> GpuDevice:
    """The default device, and one whose memory the host cannot map."""
    return device if request.param == "default" else staging_device
