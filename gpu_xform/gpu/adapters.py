"""Graphics adapters of this machine, through native back ends only.

OpenGL is left out on purpose: if Vulkan has no driver, wgpu may fall back to it silently, and compute shaders there are
slower and less tested.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import tempfile
from collections.abc import Iterator

from .._core.forks import refuse_fork
from .._core.interrupts import defer_interrupts
from .._core.public import public
from ..device import Adapter, Limits
from ..errors import NoAdapterError
from .binding import set_instance_extras, wgpu
from .drivers import suggest_driver
from .type_lookups import narrow_type_lookups

NATIVE_BACKENDS = {"darwin": ["Metal"], "win32": ["DX12", "Vulkan"]}.get(sys.platform, ["Vulkan"])
FASTEST_FIRST = ("DiscreteGPU", "IntegratedGPU", "VirtualGPU", "Unknown", "CPU")

narrow_type_lookups()


@public
def adapters() -> list[Adapter]:
    """List the graphics adapters of this machine, the fastest kind first.

    Returns
    -------
    list of Adapter
        Empty if there is no driver. `Device(adapter.name)` opens one, `Device(index=1)` the second.

    Raises
    ------
    DeviceError
        If the process is a fork of one that has opened a device.
    """
    refuse_fork()
    with defer_interrupts():
        return [describe_adapter(adapter) for adapter in list_native_adapters()]


def describe_adapter(adapter: wgpu.GPUAdapter) -> Adapter:
    """Read what wgpu knows of an adapter."""
    info, limits = adapter.info, adapter.limits
    return Adapter(
        name=info["device"],
        kind=info["adapter_type"],
        backend=info["backend_type"],
        driver=info["description"],
        limits=Limits(
            max_buffer_bytes=limits["max-buffer-size"],
            max_binding_bytes=limits["max-storage-buffer-binding-size"],
            max_workgroups=limits["max-compute-workgroups-per-dimension"],
            max_workgroup_size=min(
                limits["max-compute-workgroup-size-x"], limits["max-compute-invocations-per-workgroup"]
            ),
            max_texture_side=limits["max-texture-dimension-2d"],
        ),
        features=frozenset(adapter.features),
    )


def find_adapter(name: str | None) -> wgpu.GPUAdapter:
    """Return the fastest adapter whose name contains `name`, in any case, or the one at the place "#1" of all.

    Raises `NoAdapterError` if there is none.
    """
    found = list_native_adapters()
    if not found:
        raise NoAdapterError(
            f"no graphics adapter with a {' or '.join(NATIVE_BACKENDS)} driver; arrays of points can be transformed "
            f"without, by gx.Device('host') or --adapter host. {suggest_driver()}"
        )
    if name is not None and re.fullmatch(r"#\d{1,9}", name):
        if int(name[1:]) < len(found):
            return found[int(name[1:])]
        names = ", ".join(f"#{place} {adapter.info['device']!r}" for place, adapter in enumerate(found))
        raise NoAdapterError(f"no graphics adapter at {name!r}; there are: {names}")
    for adapter in found:
        if name is None or name.casefold() in adapter.info["device"].casefold():
            return adapter
    names = ", ".join(repr(adapter.info["device"]) for adapter in found)
    raise NoAdapterError(f"no graphics adapter has {name!r} in its name; there are: {names}")


def list_native_adapters() -> list[wgpu.GPUAdapter]:
    """Enumerate the native adapters, the fastest kind first."""
    with lend_runtime_dir():
        # Another user of wgpu in this process may have made the instance: its other back ends are left out below.
        with contextlib.suppress(RuntimeError):
            set_instance_extras(backends=NATIVE_BACKENDS)
        found = wgpu.gpu.enumerate_adapters_sync()
    native = {"D3D12", *NATIVE_BACKENDS}
    return sorted(
        (adapter for adapter in found if adapter.info["backend_type"] in native),
        key=lambda adapter: FASTEST_FIRST.index(adapter.info["adapter_type"]),
    )


@contextlib.contextmanager
def lend_runtime_dir() -> Iterator[None]:
    """Lend the drivers a private XDG_RUNTIME_DIR if none is set: without one, Mesa complains on standard error."""
    before = os.environ.get("XDG_RUNTIME_DIR")
    if before or not sys.platform.startswith("linux"):
        yield
        return
    with tempfile.TemporaryDirectory(prefix="gpu_xform-") as private:
        os.environ["XDG_RUNTIME_DIR"] = private
        try:
            yield
        finally:
            if before is None:
                os.environ.pop("XDG_RUNTIME_DIR", None)
            else:
                os.environ["XDG_RUNTIME_DIR"] = before
