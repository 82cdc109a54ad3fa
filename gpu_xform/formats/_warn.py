"""Warnings about a model file, which name it as errors do."""

import contextlib
import sys
import warnings
from collections.abc import Iterator
from contextvars import ContextVar

from ..errors import MeshWarning

_file_name: ContextVar[str] = ContextVar("file_name", default="")


@contextlib.contextmanager
def name_file(name: str) -> Iterator[None]:
    """Put "NAME: " before the warnings that the block issues."""
    token = _file_name.set(name)
    try:
        yield
    finally:
        _file_name.reset(token)


def warn(message: str) -> None:
    """Issue a MeshWarning at the line that called the package."""
    name = _file_name.get()
    package = __name__.partition(".")[0]
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        level, frame = level + 1, frame.f_back
    warnings.warn(f"{name}: {message}" if name else message, MeshWarning, stacklevel=level)
