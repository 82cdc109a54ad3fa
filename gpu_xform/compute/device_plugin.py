"""The device of each worker of a Dask cluster."""

import os
from typing import Any

from .._core.public import public
from ..device import ADAPTER_VARIABLE, HOST, default_device
from ..errors import ArgumentTypeError, MissingExtraError, NoAdapterError
from ..gpu.adapters import adapters

try:
    from distributed import WorkerPlugin
except ImportError:
    raise MissingExtraError("workers need Dask: pip install 'gpu_xform[dask]'") from None


@public
class DevicePlugin(WorkerPlugin):
    """A plugin of Dask workers that opens the device of each: `client.register_plugin(gx.dask.DevicePlugin())`.

    Where the workers' GPU_XFORM_ADAPTER names one, all take it. Else worker 0 of a machine takes the first graphics
    adapter that is no CPU, worker 1 the second, and so on around; where there is none, the host device. A worker's
    number is its name in a `LocalCluster` or `dask worker --name`, else 0.

    Parameters
    ----------
    adapter : str, optional
        The same adapter for all workers, as in `Device`.
    """

    name = "gpu_xform-device"
    idempotent = True

    def __init__(self, adapter: str | None = None) -> None:
        if adapter is not None and not isinstance(adapter, str):
            raise ArgumentTypeError.expecting("adapter", "be a text", type(adapter).__name__)
        self._adapter = adapter

    def setup(self, worker: Any) -> None:
        """Open the device of a worker's slot."""
        default_device(self._adapter or os.environ.get(ADAPTER_VARIABLE) or choose_slot(str(worker.name)))

    def teardown(self, worker: Any) -> None:
        """Do nothing: the device ends with the process."""


def choose_slot(name: str) -> str:
    """Return the adapter, as in `Device`, of the worker of a name."""
    try:
        gpus = [place for place, adapter in enumerate(adapters()) if adapter.kind != "CPU"]
    except NoAdapterError:
        gpus = []
    digits = name.rpartition("-")[2]
    return f"#{gpus[int(digits) % len(gpus) if digits.isdecimal() else 0]}" if gpus else HOST
