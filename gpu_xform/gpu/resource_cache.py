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
            buffer = self._find(owner, key)
            if buffer is None:
                content = np.ascontiguousarray(array())
                buffer = self._create(key, max(content.nbytes, 4))
                if content.nbytes:
                    buffer.upload(content)
            return self._keep(owner, key, buffer)

    def get_filled(self, owner: object, key: Hashable, n_bytes: int, fill: Callable[[Buffer], None]) -> Buffer:
        """Return the buffer of `owner` under `key`, of `n_bytes`, which `fill` has filled at the first call."""
        with self._context.lock:
            buffer = self._find(owner, key)
            if buffer is None:
                buffer = self._create(key, n_bytes)
                fill(buffer)
            return self._keep(owner, key, buffer)

    def _find(self, owner: object, key: Hashable) -> Buffer | None:
        entry = self._entries.get((id(owner), key))
        return entry.buffer if entry and entry.buffer.is_at_rest() else None

    def _create(self, key: Hashable, n_bytes: int) -> Buffer:
        return Buffer(self._context, n_bytes, label=f"cached: {key}", persistent=True)

    def _keep(self, owner: object, key: Hashable, buffer: Buffer) -> Buffer:
        """Put a buffer last among those that may go; it is filled."""
        slot = (id(owner), key)
        entry = self._entries.get(slot)
        # A finalizer may run anywhere, in the middle of a submission as well: it only leaves word, and not in Python,
        # where Ctrl+C would be lost.
        if entry is None or entry.buffer is not buffer:
            self._entries[slot] = _Entry(weakref.ref(owner, self._dead.append), buffer)
        self._entries.move_to_end(slot)
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
