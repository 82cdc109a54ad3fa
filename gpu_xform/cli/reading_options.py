"""The options of how model files are read: where they hold, and which files they are not for."""

from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import ArgumentError


@contextmanager
def use_typed_limits(options: Namespace) -> Iterator[None]:
    """Let model files that are read in the block have --file-limits and --isolated; else they have what they had."""
    limits, isolated = getattr(options, "file_limits", None), getattr(options, "isolated", False)
    if limits is None and not isolated:
        yield
        return
    from ..formats.limits import as_limits, is_isolated, use_limits

    with use_limits(as_limits(limits), isolated=isolated or is_isolated()):
        yield


def require_no_reading_options(options: Namespace, path: str) -> None:
    """Raise `ArgumentError` if an option of how models are read was typed, for a file that is read in parts."""
    for name in ("file_limits", "isolated", "pose", "tolerance"):
        if getattr(options, name, None):
            raise ArgumentError(f"{path}: --{name.replace('_', '-')} is for models, which are read whole")
