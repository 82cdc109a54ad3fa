"""Affine transforms by matrix products: within the accuracy contract, and each point for itself."""

import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from gpu_xform.compute.host import blas
from gpu_xform.compute.host.blas import POINTS_PER_BLOCK, transform_affine
from tests.support.reference_transform import AFFINE, assert_transformed, some_points

SIZES = [1, 2, 3, 4, 5, POINTS_PER_BLOCK - 1, POINTS_PER_BLOCK, POINTS_PER_BLOCK + 1, 2 * POINTS_PER_BLOCK + 3]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", SIZES)
def test_every_size_keeps_the_accuracy_contract(n: int, dtype: npt.DTypeLike) -> None:
    points = some_points(n, dtype)
    out = np.full_like(points, np.nan)
    transform_affine(points, AFFINE.astype(dtype), out)
    assert_transformed(out, points, AFFINE.astype(dtype).astype(np.float64))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_neither_place_nor_number_of_points_changes_a_byte(dtype: npt.DTypeLike) -> None:
    m = AFFINE.astype(dtype)
    points = some_points(2 * POINTS_PER_BLOCK + 9, dtype)
    whole = np.empty_like(points)
    transform_affine(points, m, whole)
    for part in (slice(1, 7), slice(3, POINTS_PER_BLOCK + 2), slice(POINTS_PER_BLOCK - 5, None)):
        out = np.empty_like(points[part])
        transform_affine(points[part], m, out)
        assert out.tobytes() == whole[part].tobytes()


ALIKE = """
import numpy as np
from gpu_xform.compute.host.blas import POINTS_PER_ROW, ROWS_PER_BLOCK
rng = np.random.default_rng(0)
for dtype in (np.float32, np.float64):
    for columns in (2, 3):
        linear = np.kron(np.eye(POINTS_PER_ROW), rng.normal(size=(columns, columns))).astype(dtype)
        for _ in range(8):
            row = rng.normal(0, 100, POINTS_PER_ROW * columns).astype(dtype)
            product = np.matmul(np.tile(row, (ROWS_PER_BLOCK, 1)), linear)
            assert (product == product[0]).all(), (dtype, columns)
"""


@pytest.mark.parametrize(
    ("kind", "threads"),  # kinds of OpenBLAS's kernels; by default this machine's
    [("", "2"), ("Prescott", "2"), ("Haswell", "1"), ("Haswell", "2"), ("Haswell", "3"), ("Haswell", "5")],
)
def test_a_row_of_a_block_is_multiplied_alike_wherever_it_is(kind: str, threads: str) -> None:
    """Before, blocks of 4,096 rows were no multiple of the tiles of Haswell and Zen: the last rows differed."""
    processor = Path("/proc/cpuinfo")
    if kind == "Haswell" and not (processor.exists() and "avx2" in processor.read_text("utf-8")):
        pytest.skip("this processor has no AVX2")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("OPENBLAS_")}
    chosen = {"OPENBLAS_CORETYPE": kind} if kind else {}
    run = partial(subprocess.run, capture_output=True, text=True, check=False)
    done = run([sys.executable, "-c", ALIKE], env={**environment, **chosen, "OPENBLAS_NUM_THREADS": threads})
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("columns", [2, 3])
def test_neither_does_the_number_of_threads(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blas, "MIN_BLOCKS_PER_THREAD", 1)
    points = some_points(3 * POINTS_PER_BLOCK + 9, np.float32, columns)
    points[[7, 2 * POINTS_PER_BLOCK]] = np.inf
    results = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("GPU_XFORM_THREADS", threads)
        results.append(points.copy())
        transform_affine(results[-1], AFFINE.astype(np.float32), results[-1])
    assert results[0].tobytes() == results[1].tobytes() == results[2].tobytes()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("columns", [2, 3])
def test_what_is_not_finite_stays_in_its_own_point(columns: int, dtype: npt.DTypeLike) -> None:
    m = AFFINE.astype(dtype)
    points = some_points(POINTS_PER_BLOCK + 50, dtype, columns)
    clean = np.empty_like(points)
    transform_affine(points, m, clean)
    spoiled = points.copy()
    spoiled[[5, 6, 100], [0, 1, 0]] = np.inf, np.nan, -np.inf
    spoiled[POINTS_PER_BLOCK + 7] = np.inf
    out = np.empty_like(points)
    transform_affine(spoiled, m, out)
    is_bad = np.isin(np.arange(len(points)), [5, 6, 100, POINTS_PER_BLOCK + 7])
    assert out[~is_bad].tobytes() == clean[~is_bad].tobytes()
    assert out[5, 0] == np.inf  # by 1.1, and the other products are finite
    assert np.isnan(out[6]).all()
