"""The buffer pool: device memory that is kept from one call to the next."""

import itertools

from .buffers import STORAGE, Buffer
from .context import GpuContext

MAX_SPARE = 2  # per owner, key and usage

Slot = tuple[str, str, int]


class BufferPool:
    """Buffers by owner, key and usage: allocating and first touching memory costs as much as filling it.

    The owner is the part of the package that uses the buffer; the key is its name there. Buffers of different owners,
    or of different usages, are never the same.
    """

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._scratch: dict[Slot, Buffer] = {}
        self._spare: dict[Slot, list[Buffer]] = {}

    def scratch(self, owner: str, key: str, n_bytes: int, usage: int = STORAGE) -> Buffer:
        """Return the kept buffer, made anew if it has fewer than `n_bytes`; what it holds is undefined.

        The caller holds the device's lock until it is done with the buffer.
        """
        slot = owner, key, usage
        kept = self._scratch.get(slot)
        if kept is not None and kept.n_bytes >= n_bytes and kept.is_at_rest():
            return kept
        if kept is not None:
            del self._scratch[slot]
            kept.release()
        self._scratch[slot] = self._allocate(slot, n_bytes)
        return self._scratch[slot]

    def acquire(self, owner: str, key: str, n_bytes: int, usage: int = STORAGE) -> Buffer:
        """Return a buffer that is the caller's alone until it is released to the pool."""
        slot = owner, key, usage
        spare = self._spare.get(slot, [])
        for buffer in list(spare):
            if buffer.n_bytes >= n_bytes:
                spare.remove(buffer)
                if buffer.is_at_rest():
                    return buffer
                buffer.release()
        return self._allocate(slot, n_bytes)

    def release(self, owner: str, key: str, buffer: Buffer) -> None:
        """Keep an acquired buffer for the next caller; beyond a few, the smallest is freed, and so is one in use."""
        if not buffer.is_at_rest():
            buffer.release()
            return
        spare = self._spare.setdefault((owner, key, buffer.usage), [])
        spare.append(buffer)
        spare.sort(key=lambda each: each.n_bytes)
        if len(spare) > MAX_SPARE:
            spare.pop(0).release()

    def clear(self) -> None:
        """Free every kept buffer."""
        for buffer in [*self._scratch.values(), *itertools.chain(*self._spare.values())]:
            buffer.release()
        self._scratch.clear()
        self._spare.clear()

    def _allocate(self, slot: Slot, n_bytes: int) -> Buffer:
        owner, key, usage = slot
        return Buffer(self._context, n_bytes, usage, label=f"{owner}: {key}", persistent=True)
