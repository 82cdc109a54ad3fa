"""wgpu, imported here alone, so that whatever needs it raises one error where it cannot be imported."""

from .._core.interrupts import defer_interrupts
from ..errors import NoAdapterError

try:
    with defer_interrupts():
        import wgpu
        from wgpu.backends.wgpu_native import ffi, lib
        from wgpu.backends.wgpu_native.extras import set_instance_extras
except (ImportError, OSError) as error:  # OSError of a library that wgpu loads
    raise NoAdapterError(
        f"graphics adapters are used by wgpu, which can't be imported: {type(error).__name__}: {error}; "
        "arrays of points can be transformed without, by gx.Device('host') or --adapter host"
    ) from error

__all__ = ["ffi", "lib", "set_instance_extras", "wgpu"]
