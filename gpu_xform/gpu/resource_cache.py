"""The resource cache: arrays that stay on the device between pictures, as long as what they belong to lives."""

import weakref
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .buffers import Buffer
from .context import GpuContext

MAX_CACHED_BYTES = 512 << 20  # kept from one picture to the next


class _Entry(NamedTuple):
    owner: "weakref.ref[Any]"  # kept, so that it calls back
    buffer: Buffer


class ResourceCache:
    """Buffers by owner, an immutable object, and key; the least recently used go first."""

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._entries: OrderedDict[tuple[int, Hashable], _Entry] = OrderedDict()
        self._dead: deque[weakref.ref[Any]] = deque()

    def get(self, owner: object, key: Hashable, array: Callable[[], npt.NDArray[Any]]) -> Buffer:
        """Return the buffer of `owner` under `key`, filled with `array()` at the first call.

        For an empty array it has four bytes. It stays valid until the next `trim`.
        """
        with self._context.lock:
            slot = (id(owner), key)
            if slot in self._entries and self._entries[slot].buffer.is_at_rest():
                self._entries.move_to_end(slot)
                return self._entries[slot].buffer
            content = np.ascontiguousarray(array())
            buffer = Buffer(self._context, max(content.nbytes, 4), label=f"cached: {key}", persistent=True)
            if content.nbytes:
                buffer.upload(content)
            # A finalizer may run anywhere, in the middle of a submission as well: it only leaves word, and not in
            # Python, where Ctrl+C would be lost.
            self._entries[slot] = _Entry(weakref.ref(owner, self._dead.append), buffer)
            return buffer

    def trim(self) -> None:
        """Release what belongs to objects that are gone, then what is over the budget."""
        with self._context.lock:
            while self._dead:
                dead = self._dead.popleft()
                for slot in [slot for slot, entry in self._entries.items() if entry.owner is dead]:
                    self._entries.pop(slot).buffer.release()
            n_bytes = sum(entry.buffer.n_bytes for entry in self._entries.values())
            while n_bytes > MAX_CACHED_BYTES:
                _, entry = self._entries.popitem(last=False)
                n_bytes -= entry.buffer.n_bytes
                entry.buffer.release()

    def clear(self) -> None:
        """Release everything."""
        for entry in self._entries.values():
            entry.buffer.release()
        self._entries.clear()
