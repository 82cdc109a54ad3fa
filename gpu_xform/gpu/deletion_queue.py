"""The deletion queue: objects of wgpu are freed where Ctrl+C waits, not where Python happens to drop what owns them.

Their destructors are written in Python, which prints what is raised in a destructor, and goes on: Ctrl+C would be lost.
"""

import contextlib
import weakref
from collections import deque
from typing import Any, TypeVar

from .binding import wgpu

T = TypeVar("T")

_handles: dict[weakref.ref[Any], tuple[Any, ...]] = {}
_gone: deque[weakref.ref[Any]] = deque()


def own(owner: object, *handles: object) -> None:
    """Keep objects of wgpu until `owner` is gone and `flush` is called."""
    # It may go anywhere, in the middle of a submission as well: that only leaves word, and not in Python.
    _handles[weakref.ref(owner, _gone.append)] = handles


def flush() -> None:
    """Free what owners that are gone have left; called in blocks of `defer_interrupts`, never in a fork."""
    while _gone:
        with contextlib.suppress(IndexError):  # another thread was faster
            for handle in _handles.pop(_gone.popleft()):
                if isinstance(handle, wgpu.GPUBuffer | wgpu.GPUTexture):
                    handle.destroy()  # a bind group that is kept would hold their memory


def list_living(kind: type[T]) -> list[T]:
    """Return the owners of a class that are not gone."""
    return [owner for reference in list(_handles) if isinstance(owner := reference(), kind)]
