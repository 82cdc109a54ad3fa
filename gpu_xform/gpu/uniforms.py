"""Uniforms: many small structs in one uniform buffer."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .buffers import UNIFORM
from .device import GpuDevice
from .dispatch import Binding
from .layouts import as_bytes

OFFSET_ALIGNMENT_BYTES = 256  # of a binding's offset: the most that WebGPU lets an adapter ask for


def upload(device: GpuDevice, owner: str, key: str, structs: Sequence[npt.NDArray[Any]]) -> list[Binding]:
    """Put the structs, one after the other, into the pool's buffer of `owner` under `key`; return where each lies.

    What the buffer holds already, as for the frames of an animation, is not sent again.
    """
    if not structs:
        return []
    largest = max(struct.nbytes for struct in structs)
    spacing = -(-largest // OFFSET_ALIGNMENT_BYTES) * OFFSET_ALIGNMENT_BYTES
    slots = np.zeros((len(structs), spacing), np.uint8)
    for slot, struct in zip(slots, structs, strict=True):
        slot[: struct.nbytes] = as_bytes(struct)
    buffer = device.pool.scratch(owner, key, slots.nbytes, UNIFORM)
    buffer.upload_changed(slots)
    return [Binding(buffer, i * spacing, struct.nbytes) for i, struct in enumerate(structs)]
