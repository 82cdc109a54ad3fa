"""Arrays that stay on the device between pictures, for as long as what they belong to lives."""

import weakref
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .buffers import Buffer

if TYPE_CHECKING:
    from .device import Device

MOST_BYTES = 512 << 20  # kept from one picture to the next


class _Resident(NamedTuple):
    owner: "weakref.ref[Any]"  # kept, so that it calls back
    buffer: Buffer


class Residents:
    """Buffers by owner, an immutable object, and role; the least recently used go first."""

    def __init__(self, device: "Device") -> None:
        self._device = device
        self._kept: OrderedDict[tuple[int, Hashable], _Resident] = OrderedDict()
        self._dead: deque[int] = deque()

    def get(self, owner: object, role: Hashable, array: Callable[[], npt.NDArray[Any]]) -> Buffer:
        """Return the buffer for `role` of `owner`, filled with `array()` at the first call.

        For an empty array it has four bytes. It stays valid until the next `trim`.
        """
        with self._device.lock:
            key = (id(owner), role)
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key].buffer
            content = np.ascontiguousarray(array())
            buffer = Buffer(self._device, max(content.nbytes, 4), stays=True)
            if content.nbytes:
                buffer.upload(content)
            number = id(owner)
            # A finalizer may run anywhere, in the middle of a submission as well: it only leaves word.
            reference = weakref.ref(owner, lambda _: self._dead.append(number))
            self._kept[key] = _Resident(reference, buffer)
            return buffer

    def trim(self) -> None:
        """Release what belongs to objects that are gone, and what is over the budget."""
        with self._device.lock:
            while self._dead:
                number = self._dead.popleft()
                for key in [key for key in self._kept if key[0] == number and self._kept[key].owner() is None]:
                    self._kept.pop(key).buffer.release()
            n_bytes = sum(resident.buffer.n_bytes for resident in self._kept.values())
            while n_bytes > MOST_BYTES:
                _, resident = self._kept.popitem(last=False)
                n_bytes -= resident.buffer.n_bytes
                resident.buffer.release()

    def clear(self) -> None:
        """Release everything."""
        for resident in self._kept.values():
            resident.buffer.release()
        self._kept.clear()
