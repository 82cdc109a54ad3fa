import dataclasses
import gc
import os
import signal
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from gpu_xform.errors import PrecisionError
from gpu_xform.gpu.context import MAPPABLE, WANTED_FEATURES, GpuContext
from gpu_xform.gpu.device import GpuDevice, default_gpu_device
from gpu_xform.raster.names import RASTERIZERS
from tests.support.browser import Browser
from tests.support.goldens import FAILURES, FOLDER, Goldens, driver_of
from tests.support.markers import mark_by_dtypes, mark_by_fixtures, params_of
from tests.support.types import Pixels
from tests.support.xvfb import Screen

# A process started in the background may ignore Ctrl+C, and so do its children; the tests interrupt both.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("local", deadline=None, max_examples=40, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("local"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-goldens", action="store_true", help="write the golden pictures that differ, and fail")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect without the garbage collector, which would look through thousands of tests again and again."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


@pytest.hookimpl(tryfirst=True)  # before `-m` selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    mark_by_fixtures(items)
    mark_by_dtypes(items)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what needs double precision on an adapter without; fail on lavapipe, which has it."""
    if item.get_closest_marker("float64") is None or params_of(item).get("process_device") == "host":
        return
    device = default_gpu_device()
    if not device.has_float64:
        if "llvmpipe" in device.adapter.name:
            pytest.fail(f"{device} should compute in double precision")
        pytest.skip(f"{device} has no double precision")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Skip what turns out to need double precision, as an array in the midst of a test, on an adapter without it."""
    try:
        return (yield)
    except PrecisionError as error:
        if default_gpu_device().has_float64:
            raise
        pytest.skip(f"{item.name} needs double precision: {error}")


@pytest.fixture
def working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, in which the test runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def suite_goldens(request: pytest.FixtureRequest, device: GpuDevice) -> Goldens:
    """The goldens of this suite, compared on the default device; failures are left in `test-failures/`."""
    return Goldens(FOLDER, driver_of(device.adapter), FAILURES, request.config.getoption("--update-goldens"))


@pytest.fixture
def assert_golden(suite_goldens: Goldens) -> Callable[[Pixels, str], None]:
    """Compare a picture with the golden of a name, as `Goldens.check` says."""
    return suite_goldens.check


@pytest.fixture(params=RASTERIZERS[1:])
def rasterizer_name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Each rasteriser, which draws unless the test names one."""
    monkeypatch.setenv("GPU_XFORM_RASTERIZER", request.param)
    return str(request.param)


@pytest.fixture(scope="session")
def device() -> GpuDevice:
    """The default device. A machine without one fails: it cannot test this library."""
    return default_gpu_device()


@pytest.fixture(scope="session")
def device_with_limits(device: GpuDevice) -> Iterator[Callable[..., GpuDevice]]:
    """Make a device that plans by smaller limits: `device_with_limits(max_binding_bytes=65536)`."""
    made: dict[tuple[tuple[str, int], ...], GpuDevice] = {}

    def make(**limits: int) -> GpuDevice:
        key = tuple(sorted(limits.items()))
        if key not in made:
            made[key] = GpuDevice(limits=dataclasses.replace(device.limits, **limits))
        return made[key]

    yield make
    for other in made.values():
        other.close()


@pytest.fixture(scope="session")
def staging_device() -> Iterator[GpuDevice]:
    """A device whose memory the host cannot map, as on a discrete GPU."""
    with GpuDevice.from_context(GpuContext(wanted_features=WANTED_FEATURES - {MAPPABLE})) as staging:
        assert not staging.host_mappable
        yield staging


@pytest.fixture(scope="session")
def single_device() -> Iterator[GpuDevice]:
    """A device without double precision, as on Metal; nor can the host map its memory."""
    with GpuDevice.from_context(GpuContext(wanted_features=frozenset())) as single:
        assert not single.has_float64
        yield single


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A headless Chromium, started by the first test that uses it. A machine without one fails."""
    with Browser() as running:
        yield running


@pytest.fixture(scope="session")
def screen() -> Iterator[Screen]:
    """A screen for windows, started by the first test that uses it. A machine without one fails."""
    with Screen() as running:
        yield running
