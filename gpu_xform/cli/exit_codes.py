"""Exit codes of the command, and the line on standard error that goes with each failure."""

from .._core.error_context import has_prefix
from ..errors import DeviceError, GpuXformError, NoAdapterError, ShaderError

DEVICE_FAILED, WRONG_INPUT, NO_ADAPTER, MISMATCH = 1, 2, 3, 4
PIPE_CLOSED = 141  # what a shell reports of a program that SIGPIPE has ended

FAILURES = (OSError, MemoryError, GpuXformError)


class MismatchError(GpuXformError):
    """A picture does not match its reference."""


def exit_code_for(error: Exception) -> int:
    """Return the exit code for `error`, one of FAILURES; the lower the code, the graver the failure."""
    match error:
        case MemoryError():  # the device's memory included
            return WRONG_INPUT
        case NoAdapterError():
            return NO_ADAPTER
        case DeviceError() | ShaderError():
            return DEVICE_FAILED
        case MismatchError():
            return MISMATCH
        case _:
            return WRONG_INPUT


def format_error(error: Exception, subject: str = "") -> str:
    """Return the line to print for `error`, one of FAILURES; `subject` precedes a message that does not begin so."""
    text = str(error)
    if isinstance(error, OSError):
        reason = error.strerror or text
        text = f"{error.filename}: {reason}" if error.filename else reason
    elif isinstance(error, MemoryError):
        text = text or "not enough memory"
    text = "; ".join([text, *getattr(error, "__notes__", ())])
    if subject and not has_prefix(error, subject):
        text = f"{subject}: {text}"
    return f"gpu-xform: error: {' '.join(text.split())}\n"
