"""The limits of what model files may hold, as they were typed: for all files of a command, or for those of a layer."""

from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def use_typed_limits(options: Namespace) -> Iterator[None]:
    """Let model files that are read in the block have --file-limits and --isolated; what is not typed stays as it is."""
    limits, isolated = getattr(options, "file_limits", None), getattr(options, "isolated", False)
    if limits is None and not isolated:
        yield
        return
    from ..formats.limits import as_limits, is_isolated, use_limits

    with use_limits(as_limits(limits), isolated=isolated or is_isolated()):
        yield
