"""Every test of pictures runs with each rasteriser."""

import pytest

from gpu_xform.raster.names import RASTERIZERS


@pytest.fixture(params=RASTERIZERS[1:], autouse=True)
def rasterizer_name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The rasteriser that draws unless a test names one."""
    monkeypatch.setenv("GPU_XFORM_RASTERIZER", request.param)
    return str(request.param)
