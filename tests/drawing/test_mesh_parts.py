"""Meshes cut into parts: every row is in one part, whose points are those it names."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.drawing.mesh_parts import split_by_points


@given(st.integers(0, 50), st.sampled_from([2, 3]), st.integers(1, 40), st.integers(3, 30), st.integers(0, 2**32 - 1))
def test_parts_hold_all_rows_in_order_and_few_points(
    n_rows: int, n_ends: int, n_points: int, most: int, seed: int
) -> None:
    indices = np.random.default_rng(seed).integers(0, n_points, (n_rows, n_ends))
    parts = list(split_by_points(indices, n_points, most))
    whole = [np.empty((0, n_ends), np.int64), *(part.points[part.indices] for part in parts)]
    assert np.array_equal(np.concatenate(whole), indices)
    end = 0
    for part in parts:
        assert part.rows.start == end
        end = part.rows.stop
        assert len(part.indices) == end - part.rows.start
        assert part.indices.dtype == np.uint32
        assert len(part.points) <= most
        assert np.array_equal(part.points, np.unique(indices[part.rows]))
    assert end == n_rows
