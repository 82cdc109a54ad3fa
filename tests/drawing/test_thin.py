"""Thinning: some of many points, chosen evenly, with what belongs to them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.drawing.thin import choose_rows, thin_layer
from gpu_xform.errors import ArgumentError

POINTS = np.random.default_rng(3).normal(size=(1000, 3))
SIZE = (60, 50)


@given(n_points=st.integers(1, 10**10), share=st.floats(0.0, 1.0))
def test_one_row_of_each_run_is_chosen(n_points: int, share: float) -> None:
    n = max(1, min(int(share * n_points), 1000))
    rows = choose_rows(n_points, n)
    bounds = [k * n_points // n for k in range(n + 1)]
    assert ((rows >= bounds[:-1]) & (rows < bounds[1:])).all()
    assert np.array_equal(rows, choose_rows(n_points, n))


def test_what_belongs_to_a_point_goes_with_it() -> None:
    rows = choose_rows(1000, 70)
    for style in ({"scalars": POINTS[:, 0]}, {"vertex_colors": ["red", "blue"] * 500}, {"scalars": "z"}):
        thinned = gx.render_array(POINTS, size=SIZE, max_points=70, **style)
        values = {
            name: value if isinstance(value, str) else np.asarray(value)[rows].tolist() for name, value in style.items()
        }
        assert np.array_equal(thinned, gx.render_array(POINTS[rows], size=SIZE, **values))  # type: ignore[arg-type]


def test_a_file_and_a_command_are_thinned(tmp_path: Path) -> None:
    gx.save_mesh(gx.Mesh(POINTS), tmp_path / "scan.ply")
    shown = gx.render_array(str(tmp_path / "scan.ply"), size=SIZE, max_points=50)
    assert np.array_equal(shown, gx.render_array(POINTS[choose_rows(1000, 50)], size=SIZE))
    typed = ["render", str(tmp_path / "scan.ply"), "-o", str(tmp_path / "out.png"), "--max-points", "50"]
    assert main([*typed, "--resolution", "60,50"]) == 0


def test_what_is_not_thinned() -> None:
    cube = gx.Layer(gx.samples.cube(), max_points=2)
    few = gx.Layer(POINTS, max_points=1000)
    assert thin_layer(cube) is cube
    assert thin_layer(few) is few
    with pytest.raises(ArgumentError, match="edges must not be given by indices if max_points leaves points out"):
        gx.render(POINTS, edges=[(0, 1)], max_points=5)
    with (
        gx.PointBuffer(POINTS.astype(np.float32)) as buffer,
        pytest.raises(ArgumentError, match="max_points must go with points in mem"),
    ):
        gx.render(buffer, max_points=5)
