"""Translation of wgpu's errors into those of gpu_xform."""

import contextlib
from collections.abc import Iterator

from ..errors import DeviceError, DeviceMemoryError
from .binding import wgpu

MEMORY_WORDS = ("not enough memory", "out of memory")
LOSS_WORDS = "device is lost"


class DeviceLostError(DeviceError):
    """The device is lost: it takes no more work."""


@contextlib.contextmanager
def translate_wgpu_errors(action: str, *labels: str) -> Iterator[None]:
    """Turn what wgpu raises in the block into `DeviceMemoryError` or `DeviceError`.

    action : what was tried: "allocate 4 bytes"
    labels : those of the objects that were used, because wgpu does not always say which it means
    """
    try:
        yield
    except wgpu.GPUError as error:
        text = str(error).strip()
        named = f"{action} ({', '.join(map(repr, labels))})" if labels else action
        # wgpu reports exhausted memory as a validation error: only its words tell.
        if isinstance(error, wgpu.GPUOutOfMemoryError) or any(words in text.casefold() for words in MEMORY_WORDS):
            raise DeviceMemoryError(f"the device has not enough memory to {named}") from error
        raise_if_lost(error, named)
        raise DeviceError(f"the device could not {named}: {text}") from error


def raise_if_lost(error: wgpu.GPUError, action: str) -> None:
    """Raise `DeviceLostError` for an error that is not about what was tried, but about a device that has been lost."""
    if LOSS_WORDS in str(error).casefold():
        raise DeviceLostError(f"the device could not {action}: {str(error).strip()}") from error
