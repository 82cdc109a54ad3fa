"""The context of an error: a prefix that says which of several inputs it is about."""

import contextlib
from collections.abc import Iterator
from typing import TypeVar

from ..errors import ArgumentError, ArgumentTypeError, GpuXformError, MeshError

_Error = TypeVar("_Error", bound=GpuXformError)


def prefix_error(error: _Error, prefix: str) -> _Error:
    """Return a copy of an error with "PREFIX: " before its message."""
    copied = type(error)(f"{prefix}: {error}")
    copied.__dict__.update(error.__dict__, _prefix=prefix)
    return copied


def has_prefix(error: Exception, prefix: str) -> bool:
    """Return whether the message of an error begins with "PREFIX: " already; OSError names its file."""
    first = error.filename if isinstance(error, OSError) else getattr(error, "_prefix", None)
    return bool(first == prefix)


@contextlib.contextmanager
def prefix_errors(prefix: str) -> Iterator[None]:
    """Put "PREFIX: " before the message of an error about an argument or a mesh that the block raises."""
    try:
        yield
    except (ArgumentError, ArgumentTypeError, MeshError) as error:
        raise prefix_error(error, prefix) from error.__cause__
