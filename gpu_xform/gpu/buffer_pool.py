"""Device memory that is kept from one call to the next."""

import itertools
from typing import TYPE_CHECKING

from .buffers import STORAGE, Buffer

if TYPE_CHECKING:
    from .device import Device

MOST_SPARE = 2  # of a role


class Pool:
    """Memory kept for the next call: allocating and first touching memory costs as much as filling it."""

    def __init__(self, device: "Device") -> None:
        self._device = device
        self._kept: dict[str, Buffer] = {}
        self._spare: dict[str, list[Buffer]] = {}

    def get(self, role: str, n_bytes: int, usage: int = STORAGE) -> Buffer:
        """Return the buffer kept for `role`, made anew where it is smaller than `n_bytes`; what it holds is undefined.

        The caller holds the device's lock until it is done with the buffer.
        """
        kept = self._kept.get(role)
        if kept is not None and kept.n_bytes >= n_bytes:
            return kept
        if kept is not None:
            del self._kept[role]
            kept.release()
        self._kept[role] = Buffer(self._device, n_bytes, usage, stays=True)
        return self._kept[role]

    def take(self, role: str, n_bytes: int, usage: int = STORAGE) -> Buffer:
        """Return a buffer that is the caller's alone until it is given back."""
        for buffer in self._spare.get(role, []):
            if buffer.n_bytes >= n_bytes:
                self._spare[role].remove(buffer)
                return buffer
        return Buffer(self._device, n_bytes, usage, stays=True)

    def give_back(self, role: str, buffer: Buffer) -> None:
        """Keep a buffer that was taken for the next who takes one; beyond a few, the smallest is released."""
        spare = self._spare.setdefault(role, [])
        spare.append(buffer)
        spare.sort(key=lambda each: each.n_bytes)
        if len(spare) > MOST_SPARE:
            spare.pop(0).release()

    def clear(self) -> None:
        """Release every kept buffer."""
        for buffer in [*self._kept.values(), *itertools.chain(*self._spare.values())]:
            buffer.release()
        self._kept.clear()
        self._spare.clear()
