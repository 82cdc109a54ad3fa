"""What went wrong, as one line on standard error and an exit code."""

from ..errors import DeviceError, GpuXformError, NoAdapterError, ShaderError

DEVICE_FAILED, WRONG_INPUT, NO_ADAPTER, DIFFERENT = 1, 2, 3, 4
FAILURES = (OSError, MemoryError, GpuXformError)


class DifferentError(GpuXformError):
    """A picture is not like its reference."""


def exit_code(error: Exception) -> int:
    """Return the exit code that stands for `error`, one of FAILURES; the lower, the graver."""
    match error:
        case MemoryError():  # the device's memory included
            return WRONG_INPUT
        case NoAdapterError():
            return NO_ADAPTER
        case DeviceError() | ShaderError():
            return DEVICE_FAILED
        case DifferentError():
            return DIFFERENT
        case _:
            return WRONG_INPUT


def line(error: Exception, about: str = "") -> str:
    """Return what to print of `error`, one of FAILURES; `about` goes before a message that does not begin with it."""
    text = str(error)
    if isinstance(error, OSError):
        reason = error.strerror or text
        text = f"{error.filename}: {reason}" if error.filename else reason
    elif isinstance(error, MemoryError):
        text = text or "not enough memory"
    if about and not text.startswith(f"{about}: "):
        text = f"{about}: {text}"
    return f"gpu-xform: error: {' '.join(text.split())}\n"
