"""Every exception that gpu_xform raises, in one tree, and its two warnings.

`GpuXformError` is the root. Where Python users expect a `ValueError`, a `TypeError` or a `RuntimeError`, the class is
one of those as well. Only the operating system's own refusals (`FileNotFoundError`, `PermissionError`, a full disk)
pass through unchanged: Python already names the file and the reason.
"""


class GpuXformError(Exception):
    """The root of every error raised here."""


class ArgumentError(GpuXformError, ValueError):
    """An argument has the right type and an impossible value: its shape, its range, a NaN."""


class ArgumentTypeError(GpuXformError, TypeError):
    """An argument has a type or dtype that cannot be taken."""


class SingularMatrixError(ArgumentError):
    """A matrix that must be inverted has no inverse."""


class MeshError(GpuXformError, ValueError):
    """A mesh or a model file is not what it claims to be; the message names file, line or byte, and what is wrong."""


class MissingExtraError(GpuXformError, ImportError):
    """An optional library is not installed; the message names the extra of this package that brings it."""


class DisplayError(GpuXformError, RuntimeError):
    """No window can be opened; the message says why."""


class PrecisionError(GpuXformError, ValueError):
    """The device cannot compute in the precision asked for."""


class PrecisionWarning(UserWarning):
    """Single precision is too coarse for the coordinates at hand."""


class SizeWarning(UserWarning):
    """A picture is padded to a size that its format can hold."""


class NoAdapterError(GpuXformError, RuntimeError):
    """No graphics adapter, or none of the name asked for."""


class DeviceError(GpuXformError, RuntimeError):
    """The device refused or lost a piece of work."""


class DeviceMemoryError(DeviceError, MemoryError):
    """The device has no memory left for a buffer or a texture."""


class ShaderError(GpuXformError, RuntimeError):
    """A shader file is missing, imports an unknown name, or does not compile."""
