"""Structs in a uniform buffer: where they lie, and that what is there already is not sent again."""

import itertools

import numpy as np
import pytest

from gpu_xform.gpu import uniforms
from gpu_xform.gpu.device import GpuDevice
from tests.support.spies import record_uploads


@pytest.mark.parametrize("n_bytes", [16, 256, 260, 640])
def test_structs_lie_at_aligned_offsets(n_bytes: int, device: GpuDevice) -> None:
    structs = [np.full(n_bytes // 4, k, np.uint32) for k in (1, 2, 3)]
    with device.lock:
        bindings = uniforms.upload(device, "test", "structs", structs)
    assert len({binding.buffer for binding in bindings}) == 1
    offsets = [binding.offset_bytes for binding in bindings]
    assert all(offset % uniforms.OFFSET_ALIGNMENT_BYTES == 0 for offset in offsets)
    assert all(after - before >= n_bytes for before, after in itertools.pairwise(offsets))
    assert [binding.n_bytes for binding in bindings] == [n_bytes] * 3


def test_what_the_buffer_holds_is_not_sent_again(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = record_uploads(monkeypatch)
    with device.lock:
        for value in (1, 1, 2, 2, 1):
            uniforms.upload(device, "test", "repeated", [np.full(4, value, np.uint32)])
    assert sizes == [256, 256, 256]


def test_no_structs_need_no_buffer(device: GpuDevice) -> None:
    assert uniforms.upload(device, "test", "none", []) == []
