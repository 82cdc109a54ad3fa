"""wgpu's errors, said as ours."""

import contextlib
from collections.abc import Iterator

import wgpu

from ..errors import DeviceError, DeviceMemoryError

MEMORY_WORDS = ("not enough memory", "out of memory")


@contextlib.contextmanager
def translate_wgpu_errors(action: str) -> Iterator[None]:
    """Turn what wgpu raises in the block into `DeviceMemoryError` or `DeviceError`; `action` says what was tried."""
    try:
        yield
    except wgpu.GPUError as error:
        text = str(error).strip()
        # wgpu reports exhausted memory as a validation error, so that only its words tell.
        if isinstance(error, wgpu.GPUOutOfMemoryError) or any(words in text.casefold() for words in MEMORY_WORDS):
            raise DeviceMemoryError(f"the device has not enough memory to {action}") from error
        raise DeviceError(f"the device could not {action}: {text}") from error
