"""Ctrl+C is held back while modules are imported and objects of wgpu are made, and not for longer."""

import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager

import numpy as np
import pytest
import wgpu

from gpu_xform import render_array, samples, scale, transform_points
from gpu_xform._core.interrupts import Terminated, defer_interrupts, raise_terminated
from gpu_xform.gpu.context import CommandEncoder, Submittable
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster import rasterizer
from tests.support.python_run import python_output


@pytest.fixture(autouse=True)
def _python_s_own_handler() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_waits_for_the_end_of_the_outermost_block() -> None:
    done = []

    def work() -> None:
        with defer_interrupts():
            with defer_interrupts():
                signal.raise_signal(signal.SIGINT)
                done.append("inside")
            done.append("outside")
        done.append("after")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == ["inside", "outside"]


def test_an_interrupt_is_not_lost_where_the_block_fails() -> None:
    def work() -> None:
        signal.raise_signal(signal.SIGINT)
        raise ValueError

    with pytest.raises(KeyboardInterrupt), defer_interrupts():
        work()


def test_without_an_interrupt_nothing_happens() -> None:
    with defer_interrupts():
        pass
    with pytest.raises(ValueError, match="its own"), defer_interrupts():
        raise ValueError("its own")


def test_a_program_that_minds_interrupts_itself_goes_on_doing_so() -> None:
    pressed = []
    signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    with defer_interrupts():
        signal.raise_signal(signal.SIGINT)
        assert pressed == [signal.SIGINT]
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_other_threads_are_left_alone() -> None:
    handlers = []

    def work() -> None:
        with defer_interrupts():
            handlers.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert handlers == [signal.default_int_handler]


@pytest.mark.parametrize("call", ["create_command_encoder", "create_bind_group"])
def test_an_interrupted_picture_or_transform_is_finished_first(
    call: str, device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = render_array(samples.cube(), device=device, size=(40, 30)).tobytes()
    device.bind_groups.clear()
    original = getattr(type(device.context.handle), call)
    returned: list[wgpu.GPUObjectBase] = []

    def interrupted(*arguments: object, **options: object) -> object:
        if not returned:
            signal.raise_signal(signal.SIGINT)
        returned.append(original(*arguments, **options))
        return returned[-1]

    monkeypatch.setattr(type(device.context.handle), call, interrupted)
    with pytest.raises(KeyboardInterrupt):
        render_array(samples.cube(), device=device, size=(40, 30))
    assert returned
    device.kept_ready.clear()
    for n_points in (1000, 2000):  # the short way, and the long one
        device.bind_groups.clear()  # which both may share where double precision is made of single
        returned.clear()
        with pytest.raises(KeyboardInterrupt):
            transform_points(np.ones((n_points, 3)), scale(2), device=device)
        assert returned
    assert render_array(samples.cube(), device=device, size=(40, 30)).tobytes() == expected


def test_an_interrupt_waits_for_one_tile_not_for_the_whole_picture(
    device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = []
    encode_commands = GpuDevice.encode_commands

    def interrupted(own: GpuDevice, *used: Submittable, label: str) -> AbstractContextManager[CommandEncoder]:
        recorded.append(len(used))
        signal.raise_signal(signal.SIGINT)
        return encode_commands(own, *used, label=label)

    monkeypatch.setattr(rasterizer, "TILE_SIDE_PX", 32)
    monkeypatch.setattr(GpuDevice, "encode_commands", interrupted)
    with pytest.raises(KeyboardInterrupt):
        render_array(samples.cube(), device=device, size=(320, 320))
    assert len(recorded) == 1


def test_sigterm_is_deferred_where_it_raises() -> None:
    before = signal.signal(signal.SIGTERM, raise_terminated)
    done = []

    def work() -> None:
        with defer_interrupts():
            signal.raise_signal(signal.SIGTERM)
            done.append("inside")

    try:
        with pytest.raises(Terminated):
            work()
        assert done == ["inside"]
        assert signal.getsignal(signal.SIGTERM) is raise_terminated
    finally:
        signal.signal(signal.SIGTERM, before)


def test_both_handlers_are_set_again_where_both_signals_came() -> None:
    before = signal.signal(signal.SIGTERM, raise_terminated)

    def work() -> None:
        with defer_interrupts():
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGINT)

    try:
        with pytest.raises(KeyboardInterrupt):
            work()
        assert signal.getsignal(signal.SIGTERM) is raise_terminated
    finally:
        signal.signal(signal.SIGTERM, before)


INTERRUPT_IMPORT = """
    import signal, sys
    import gpu_xform as gx

    class Interrupt:
        def find_spec(self, name, path=None, target=None):
            if name == {module!r}:
                sys.meta_path.remove(self)
                signal.raise_signal(signal.SIGINT)

    signal.signal(signal.SIGINT, signal.default_int_handler)
    {before}
    sys.meta_path.insert(0, Interrupt())
    for _ in range(2):
        try:
            print({call})
        except KeyboardInterrupt:
            print("interrupted", {module!r} in sys.modules)
"""


@pytest.mark.parametrize(
    ("module", "before", "call", "result"),
    [
        ("numpy.linalg", "", "gx.inverse(gx.scale(2))[0, 0]", "0.5"),
        ("numpy.exceptions", "", "gx.samples.cube().bounds[1][0]", "1.0"),
        ("wgpu.backends.wgpu_native", "", "len(gx.adapters()) > 0", "True"),
        ("trimesh.base", "cube = gx.samples.cube()", "len(cube.to_trimesh().faces)", "12"),
    ],
)
def test_a_module_is_imported_whole_before_an_interrupt(module: str, before: str, call: str, result: str) -> None:
    """Before, NumPy stayed half imported: each later call raised `cannot load module more than once per process`."""
    code = INTERRUPT_IMPORT.format(module=module, before=before, call=call)
    assert python_output(code).splitlines() == ["interrupted True", result]
