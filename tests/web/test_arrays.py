"""Arrays as pages hold them come back as they were, through the layout that `js/arrays.js` reads."""

import json
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import hypothesis.extra.numpy as hnp
import numpy as np
import numpy.typing as npt
from hypothesis import given

from gpu_xform.samples import icosphere
from gpu_xform.web.arrays import ArrayStore


def decode(text: str, short: Mapping[str, str] | None = None) -> tuple[dict[str, Any], list[npt.NDArray[Any]]]:
    """Return the JSON and the arrays of a page's text, read one byte after the other as the script does.

    short : the names that keys have there, by those that they have here
    """
    long = {new: old for old, new in (short or {}).items()}
    digits = [60 if code == 126 else code for code in text[1:].encode()]
    words = (np.array(digits).reshape(-1, 2) - 35) @ [91, 1]
    bits = (words[:, None] >> np.arange(12, -1, -1)) & 1
    content = zlib.decompress(np.packbits(bits.ravel()[: bits.size // 8 * 8]).tobytes()[: -int(text[0]) or None])
    (n_head,) = struct.unpack("<I", content[:4])
    head: dict[str, Any] = json.loads(
        content[4 : 4 + n_head], object_pairs_hook=lambda items: {long.get(key, key): value for key, value in items}
    )
    offset, arrays = 4 + n_head, []
    for layout in head["arrays"]:
        n, columns, n_bytes = layout["n"], layout["columns"], layout["bytes"]
        planes = np.frombuffer(content, np.uint8, n * columns * n_bytes, offset).reshape(n_bytes, columns, n)
        offset += planes.size
        if layout.get("isFloat"):
            arrays.append(np.ascontiguousarray(planes.transpose(2, 1, 0)).view("<f8")[..., 0])
            continue
        words = sum(planes[i].astype(np.uint64) << (8 * i) for i in range(n_bytes)).astype(np.uint32)
        unfolded = (words >> np.uint32(1)) ^ np.where(words & np.uint32(1), np.uint32(0xFFFFFFFF), np.uint32(0))
        match layout["coding"]:
            case "signed":
                words = unfolded
            case "delta":
                words = np.cumsum(unfolded, axis=1, dtype=np.uint32)
            case "back":
                above, found = 0, []
                for back in unfolded.T.ravel().tolist():
                    found.append((above - back) % 2**32)
                    above = max(above, found[-1] + 1)
                words = np.array(found, np.uint32).reshape(words.T.shape).T
            case "again":
                new, found = iter(arrays[layout["new"]].ravel().tolist()), []
                for back in words.T.ravel().tolist():
                    found.append(found[-back] if back else next(new))
                words = np.array(found, np.uint32).reshape(words.T.shape).T
        arrays.append(words.T)
    assert offset == len(content)
    return head, arrays


@given(hnp.arrays(np.uint32, hnp.array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=9)))
def test_integers_come_back(values: npt.NDArray[np.uint32]) -> None:
    store = ArrayStore()
    number = store.add_integers(values)
    head, arrays = decode(store.encode({"size": [3, 4]}))
    assert head["size"] == [3, 4]
    assert np.array_equal(arrays[number], values)


@given(hnp.arrays(np.uint8, hnp.array_shapes(min_dims=1, max_dims=2, min_side=0, max_side=30)))
def test_indices_come_back(values: npt.NDArray[np.uint8]) -> None:
    store = ArrayStore()
    number = store.add_indices(values % np.uint8(9))
    _, arrays = decode(store.encode({}))
    assert np.array_equal(arrays[number].reshape(values.shape), values % 9)


def test_indices_that_come_again_soon_are_short() -> None:
    triangles = icosphere(3).indices.reshape(-1, 3)
    lengths = []
    for add in (ArrayStore.add_integers, ArrayStore.add_indices):
        store = ArrayStore()
        add(store, triangles)
        lengths.append(len(store.encode({})))
        head, arrays = decode(store.encode({}))
        assert np.array_equal(arrays[-1], triangles)
    assert head["arrays"][-1]["coding"] == "again"
    assert lengths[1] < lengths[0] / 2


@given(hnp.arrays(np.float64, hnp.array_shapes(min_dims=2, max_dims=2, max_side=9)))
def test_floats_come_back_bit_by_bit(values: npt.NDArray[np.float64]) -> None:
    store = ArrayStore()
    store.add_integers(np.arange(5))
    number = store.add_floats(values)
    _, arrays = decode(store.encode({}))
    assert arrays[number].tobytes() == values.tobytes()


def test_negative_numbers_keep_their_bits() -> None:
    store = ArrayStore()
    store.add_integers(np.array([[-3, 7], [2, -(1 << 19)]]))
    _, (found,) = decode(store.encode({}))
    assert found.view(np.int32).tolist() == [[-3, 7], [2, -(1 << 19)]]


def test_each_coding_is_taken_where_it_is_short_and_comes_back() -> None:
    fan = np.stack([np.arange(60), np.arange(60) + 1, np.arange(60) + 61], axis=1)
    signs = np.where(np.arange(999) % 3, 5, -5)
    tables = [np.full(999, 7), signs, np.arange(999) * 300, fan]
    store = ArrayStore()
    for table in tables:
        store.add_integers(table)
    head, arrays = decode(store.encode({}))
    assert {layout["coding"] for layout in head["arrays"]} >= {"plain", "signed", "delta"}
    for table, found in zip(tables, arrays, strict=True):
        assert np.array_equal(found.view(np.int32).squeeze(), table)
