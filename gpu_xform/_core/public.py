"""The mark of public classes and functions."""

from typing import TypeVar

_Public = TypeVar("_Public")


def public(thing: _Public) -> _Public:
    """Make `gpu_xform` the module of a class or function: pickles, tracebacks and help know no other place of it.

    So modules can move, and what was pickled before still loads.
    """
    thing.__module__ = "gpu_xform"
    return thing
