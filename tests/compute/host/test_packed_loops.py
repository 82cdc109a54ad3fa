"""Points by vectors: the bytes of the loop that takes them one by one."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.compute.host import packed_loops
from gpu_xform.compute.host.choose import MIN_COMPILED_PRODUCTS, POINTS_PER_BLOCK
from gpu_xform.device import Device


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [MIN_COMPILED_PRODUCTS, *(2 * POINTS_PER_BLOCK + k for k in (-1, 1, 7, 8, 9))])
def test_it_has_the_bytes_of_single_points(host: Device, dtype: Any, n: int) -> None:
    points = np.random.default_rng(n).normal(scale=7, size=(n, 3)).astype(dtype)
    points[n // 2], points[n // 3, 1], points[-1, 2] = np.nan, np.inf, -0.0
    matrix = gx.chain(gx.scale(0.3, 0.5, 2), gx.rotate((1, 2, 3), 0.7), gx.translate(-0.5, 2, 1))
    spaced = np.zeros((n, 4), dtype)[:, :3]
    spaced[...] = points
    expected = gx.transform_points(spaced, matrix, device=host)  # is not C-ordered: one by one
    result = gx.transform_points(points, matrix, device=host)
    assert result.tobytes() == expected.tobytes()
    assert gx.transform_points(points, matrix, out=points, device=host) is points
    assert points.tobytes() == expected.tobytes()


def test_many_points_come_by_vectors(host: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    loop = packed_loops.transform_packed

    def watch(*arrays: Any) -> None:
        calls.append(len(arrays[0]))
        loop(*arrays)

    monkeypatch.setattr("gpu_xform.compute.host.loops.transform_packed", watch)
    gx.transform_points(np.ones((MIN_COMPILED_PRODUCTS, 3), np.float32), gx.scale(2), device=host)
    assert calls == [MIN_COMPILED_PRODUCTS]
