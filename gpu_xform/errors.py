"""The exceptions and warnings of gpu_xform, in one tree under `GpuXformError`.

Where Python users expect a `ValueError`, a `TypeError` or a `RuntimeError`, the class is one of those as well. Only the
operating system's own refusals (`FileNotFoundError`, `PermissionError`, a full disk) pass through unchanged: Python
already names the file and the reason.
"""

from typing import Self


class GpuXformError(Exception):
    """The base class of every error of gpu_xform."""


class _AnyArgumentError(GpuXformError):
    """The base of both argument errors, which holds what they are about, so that no caller parses the message."""

    def __init__(self, message: str = "", *, argument: str | None = None, expected: str | None = None) -> None:
        super().__init__(message)
        self.argument = argument
        self.expected = expected

    @classmethod
    def expecting(cls, argument: str, expected: str, got: object = None, *, reason: object = None) -> Self:
        """Return the error "ARGUMENT must EXPECTED, got GOT: REASON"; `got` and `reason` may be left out."""
        message = f"{argument} must {expected}"
        if got is not None:
            message += f", got {got}"
        if reason is not None:
            message += f": {reason}"
        return cls(message, argument=argument, expected=expected)


class ArgumentError(_AnyArgumentError, ValueError):
    """An argument has the right type and an impossible value, such as a wrong shape, a number out of range, or a NaN.

    `argument` is its name and `expected` what the argument must do or be, as in the message "ARGUMENT must EXPECTED,
    got ..."; both are None if the error is not about one argument alone.
    """


class ArgumentTypeError(_AnyArgumentError, TypeError):
    """An argument has a type or dtype that is not accepted; `argument` and `expected` are those of `ArgumentError`."""


class SingularMatrixError(ArgumentError):
    """A matrix that must be inverted has no inverse."""


class MeshError(GpuXformError, ValueError):
    """A mesh or a model file is malformed; the message names the file, the line or byte, and what is wrong."""


class MissingExtraError(GpuXformError, ImportError):
    """An optional library is not installed; the message names the extra of this package that brings it."""


class DisplayError(GpuXformError, RuntimeError):
    """No window can be opened; the message says why."""


class PrecisionError(GpuXformError, ValueError):
    """The device cannot compute in the requested precision."""


class SimulationError(GpuXformError, RuntimeError):
    """A simulation went astray; `frame` is the number of the frame in which it shows, counted from its first."""

    def __init__(self, message: str = "", *, frame: int | None = None) -> None:
        super().__init__(message)
        self.frame = frame


class MeshWarning(UserWarning):
    """A model file was read, and some of what it holds is not in the mesh; the message names the file and what."""


class PrecisionWarning(UserWarning):
    """Single precision is too coarse for these coordinates."""


class DeviceWarning(UserWarning):
    """A device computes in another way than it should, or may compute wrongly; the message says which."""


class SimulationWarning(UserWarning):
    """A simulation starts from where it is likely to go astray; the message says why."""


class TextWarning(UserWarning):
    """Some labels found no room in a picture; the message says how many."""


class SizeWarning(UserWarning):
    """A picture is padded to a size that its format can hold, or a file is larger than most want it."""


class ChunkWarning(UserWarning):
    """Blocks of an array do not hold whole points, and are cut in another way; the message says how."""


class NoAdapterError(GpuXformError, RuntimeError):
    """There is no graphics adapter, or none of the requested name."""


class DeviceError(GpuXformError, RuntimeError):
    """The device refused or lost a piece of work."""


class DeviceMemoryError(DeviceError, MemoryError):
    """The device has no memory left for a buffer or a texture."""


class ShaderError(GpuXformError, RuntimeError):
    """A shader file is missing, imports an unknown name, or does not compile."""


# As `_core.public` does for every other public name.
for _class in [value for value in globals().values() if isinstance(value, type)]:
    _class.__module__ = "gpu_xform"
