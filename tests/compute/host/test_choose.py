"""Choice between compiled loops and NumPy: numba is imported late, may be missing, and may fail."""

import warnings

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.compute.host import choose
from gpu_xform.compute.host.choose import MIN_COMPILED_PRODUCTS, POINTS_PER_BLOCK, find_block_starts
from gpu_xform.device import Device
from tests.support.python_run import python_output

POINTS = np.random.default_rng(0).normal(size=(2 * MIN_COMPILED_PRODUCTS, 3))
MATRIX = gx.rotate((1, 2, 3), 0.7)


def test_few_points_import_neither_numba_nor_wgpu_and_need_no_driver() -> None:
    code = """
        import sys
        import numpy as np
        import gpu_xform as gx
        host = gx.default_device("host")
        gx.transform_points(np.ones((16383, 3)), gx.scale(2))
        gx.transform_normals(np.ones((4095, 3), np.float32), gx.scale(2), normalize=True)
        gx.bounds(np.ones((4095, 3)))
        print(sorted({"numba", "wgpu", "PIL", "trimesh", "importlib.metadata"} & set(sys.modules)))
        gx.transform_points(np.ones((16384, 3)), gx.scale(2))
        print(sorted({"numba", "wgpu"} & set(sys.modules)))
    """
    output = python_output(code, VK_DRIVER_FILES="/nonexistent", VK_ICD_FILENAMES="/nonexistent")
    assert output.splitlines() == ["[]", "['numba']"]


def test_without_numba_numpy_computes() -> None:
    code = """
        import sys
        sys.modules["numba"] = None
        import numpy as np
        import gpu_xform as gx
        host = gx.Device("host")
        points = np.random.default_rng(0).normal(size=(50_000, 3))
        moved = gx.transform_points(points, gx.translate(1, 2, 3), device=host)
        print(np.abs(moved - points - [1, 2, 3]).max() < 1e-14)
        print(np.array_equal(gx.bounds(points, device=host), [points.min(axis=0), points.max(axis=0)]))
    """
    assert python_output(code).splitlines() == ["True", "True"]


def test_if_numba_fails_numpy_computes_and_one_warning_says_why(host: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise ImportError("Numba needs NumPy 2.4 or less. Got NumPy 9.9.\nmore")

    expected = gx.project_points(POINTS, gx.perspective_from_eye(90), device=host)
    monkeypatch.setattr(choose, "_has_failed", False)
    monkeypatch.setattr(choose, "_import_loops", fail)
    with pytest.warns(gx.DeviceWarning, match=r"numba failed.*by NumPy.*ImportError: Numba needs NumPy 2.4.*9\.9\.$"):
        result = gx.project_points(POINTS, gx.perspective_from_eye(90), device=host)
    assert result.tobytes() == expected.tobytes()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gx.transform_points(POINTS, MATRIX, device=host)


def test_blocks_depend_on_the_number_of_points_alone() -> None:
    for n in (1, POINTS_PER_BLOCK - 1, POINTS_PER_BLOCK, POINTS_PER_BLOCK + 1, 5 * POINTS_PER_BLOCK + 3):
        starts = find_block_starts(n)
        assert starts[0] == 0
        assert starts[-1] == n
        assert (np.diff(starts) > 0).all()
        assert (np.diff(starts) <= POINTS_PER_BLOCK).all()
