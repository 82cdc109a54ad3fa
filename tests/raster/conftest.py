"""Every test of pictures runs with each rasteriser."""

import pytest


@pytest.fixture(autouse=True)
def each_rasterizer(rasterizer_name: str) -> str:
    """The rasteriser that draws unless a test names one."""
    return rasterizer_name
