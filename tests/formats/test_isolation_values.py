"""What leaves isolation is the same on the other side, in little text and time."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.formats.isolation_values import _decode, _encode
from gpu_xform.geometry.attributes import freeze_value
from tests.support.cost import within_cpu_s
from tests.support.isolation import carry
from tests.support.python_run import linux_only

pytestmark = linux_only


def shared_between(*shares: Any) -> dict[str, Any]:
    return {f"part {i}": {"own": i, "shared": each} for i, each in enumerate(shares)}


LONG = freeze_value({"text": "more " * 1000})
LARGE = freeze_value({"values": list(range(1000))})


@pytest.mark.parametrize(
    ("metadata", "most_bytes"),
    [
        ({"plain": [1, -2.5, "a", None, True, [], {}, {"deep": [[{"": 1e999}]]}]}, 150),
        ({"no JSON": [b"b", np.arange(3), np.array(5), np.zeros((2, 0), bool)]}, None),
        ({"\ud83d\ude00": "\ude00\ud83d", "\U0001f600": ["\ud83d\ude00", "\x00\x7f\ufffe\u2028"]}, 150),
        ({"numbers for keys": {1: "a", (2, "b"): [None]}}, 300),
        ({"long": list(range(500))}, 2500),
        (shared_between(*[LARGE] * 200), 40_000),
        (shared_between(*[LONG] * 200), 40_000),
        (shared_between(*[freeze_value({"key " * 1000: 1})] * 200), 40_000),
        (shared_between(*[{"values": [1, 2, 3]}] * 200), 20_000),
    ],
)
def test_what_a_file_says_is_the_same_after_isolation(metadata: Any, most_bytes: int | None) -> None:
    """Small parts go as JSON holds them; what is large is sent once."""
    mesh = gx.Mesh(np.eye(3), metadata=metadata)
    sent, received = carry(mesh.metadata)
    assert most_bytes is None or len(sent) < most_bytes
    assert repr(received) == repr(mesh.metadata)


@pytest.mark.parametrize("large", [[0] * 100_000, {str(i): 0 for i in range(20_000)}], ids=["list", "mapping"])
def test_what_many_parts_share_is_not_gone_through_for_each(large: Any) -> None:
    parts = freeze_value(shared_between(*[freeze_value(large)] * 10_000))
    for _ in within_cpu_s(0.5):
        _encode(parts, lambda _: 0, {})


def test_arrays_are_copied_out_of_the_shared_memory() -> None:
    shared = bytearray(np.arange(6.0).tobytes())
    array = _decode({"array": [8, [2, 2], "<f8"]}, shared, [])
    shared[:] = bytes(48)
    assert np.array_equal(array, [[1, 2], [3, 4]])
    assert not array.flags.writeable
