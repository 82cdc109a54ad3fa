"""Forks: a child of a process with a device is told so by every public call, and neither waits nor hangs at its end."""

import pytest

from tests.support.python_run import linux_only, run_python

# The parent holds a device, points on it, and both locks, in a thread that the child does not have.
FORK = """
    import os, signal, sys, threading
    import numpy as np
    import gpu_xform as gx
    from gpu_xform import device as module
    device, host = gx.default_device(), gx.Device("host")
    points = gx.PointBuffer(np.ones((40_000, 3), np.float32))
    ones = np.ones((9, 3), np.float32)
    springs = gx.Springs(gx.samples.cloth(4, 4), stretch=10.0, area_density=0.1)
    animation = gx.turntable(gx.samples.cube(), 3, size=(16, 16))
    held, release = threading.Event(), threading.Event()

    def hold():
        with device.lock, module._default_lock:
            held.set()
            release.wait()

    threading.Thread(target=hold).start()
    held.wait()
    child = os.fork()
    if child == 0:
        signal.alarm(30)
        attempts = {{
            "Device": lambda: gx.Device(),
            "default_device": lambda: gx.default_device(),
            "adapters": lambda: gx.adapters(),
            "transform_points": lambda: gx.transform_points(ones, gx.identity()),
            "with a device": lambda: gx.transform_points(ones, gx.identity(), device=device),
            "host": lambda: gx.Device("host"),
            "with the host": lambda: gx.transform_points(ones, gx.identity(), device=host),
            "bounds": lambda: gx.bounds(ones),
            "PointBuffer": lambda: gx.PointBuffer(ones),
            "numpy": lambda: points.numpy(),
            "reduce": lambda: points.bounds(),
            "convolve": lambda: gx.convolve(np.ones((9, 9), np.float32), np.ones((3, 3), np.float32)),
            "step": lambda: springs.step(),
            "render": lambda: gx.render_array(gx.samples.cube(), size=(16, 16)),
            "drawn points": lambda: gx.render_array(points, size=(16, 16)),
            "render_svg": lambda: gx.render_svg(gx.samples.cube(), size=(16, 16), hidden="remove"),
            "frame": lambda: next(iter(animation)),
        }}
        for name, attempt in attempts.items():
            try:
                attempt()
            except gx.DeviceError as error:
                if "spawn" in str(error):
                    continue
                print(name, error)
            else:
                print(name, "raised nothing")
        points.close()
        device.close()
        sys.stdout.flush()
        {end}
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == {code}
    release.set()
    assert points.numpy().sum() == 120_000
"""


@pytest.mark.slow
@linux_only
@pytest.mark.parametrize(("end", "code"), [("sys.exit(3)", 3), ("os._exit(0)", 0)])
def test_every_call_in_a_forked_child_says_spawn_and_its_end_does_not_hang(end: str, code: int) -> None:
    """Before, the driver of Mesa 26 waited at the end for threads that the child does not have."""
    result = run_python(FORK.format(end=end, code=code))
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
