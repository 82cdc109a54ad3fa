"""Translation of wgpu's errors."""

import pytest
import wgpu

from gpu_xform.errors import DeviceError, DeviceMemoryError
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.errors import translate_wgpu_errors
from tests.support.python_run import linux_only, python_output


@pytest.mark.slow
@linux_only
def test_exhausted_memory_is_a_device_memory_error(device: GpuDevice) -> None:
    if device.adapter.kind != "CPU":
        pytest.skip("the memory of this device is not the process's own, which the test limits")
    code = """
        import pathlib, resource
        import gpu_xform
        from gpu_xform.gpu.buffers import Buffer
        device = gpu_xform.Device()
        used = int(pathlib.Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + (200 << 20), -1))
        try:
            Buffer(device.context, 1 << 30, label="test")
            print("not counted")
        except gpu_xform.DeviceMemoryError as error:
            print(error)
        gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity(), device=device)
    """
    output = python_output(code)
    if output == "not counted\n":
        pytest.skip("the memory of this driver is not counted in the address space, which the test limits")
    assert output == "the device has not enough memory to allocate 1,073,741,824 bytes ('test')\n"


@pytest.mark.parametrize(
    ("raised", "expected"),
    [
        (wgpu.GPUValidationError("Validation Error: Not enough memory left"), DeviceMemoryError),
        (wgpu.GPUOutOfMemoryError("?"), DeviceMemoryError),
        (wgpu.GPUValidationError("Buffer size is greater than the maximum"), DeviceError),
        (wgpu.GPUInternalError("broken"), DeviceError),
    ],
)
def test_an_error_of_wgpu_becomes_one_of_ours(raised: Exception, expected: type[Exception]) -> None:
    with (
        pytest.raises(DeviceError, match=r"the device .* lift 3 bytes") as caught,
        translate_wgpu_errors("lift 3 bytes"),
    ):
        raise raised
    assert type(caught.value) is expected
    assert caught.value.__cause__ is raised
    assert issubclass(DeviceMemoryError, MemoryError)
