"""Arrays of other libraries, read where they lie."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.compute._arrays import as_host_array, as_point_array
from gpu_xform.errors import ArgumentTypeError
from tests.support.reference_transform import AFFINE, some_points
from tests.support.types import Array


class ByInterface:
    """An array that shows its memory by NumPy's array interface alone."""

    def __init__(self, array: Array) -> None:
        self.array = array
        self.__array_interface__ = array.__array_interface__


class ByDLPack:
    """An array that hands its memory over by DLPack alone."""

    def __init__(self, array: Array) -> None:
        self.array = array

    def __dlpack__(self, **options: Any) -> Any:
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return self.array.__dlpack_device__()


class Elsewhere(ByDLPack):
    """An array in the memory of a graphics card."""

    def __dlpack__(self, **_: Any) -> Any:
        raise BufferError("the array is on cuda:0")


@pytest.mark.parametrize("wrap", [ByInterface, ByDLPack])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_arrays_of_other_libraries_are_read_without_a_copy(wrap: Any, dtype: npt.DTypeLike) -> None:
    points = some_points(9, dtype)
    assert np.shares_memory(as_point_array(wrap(points)), points)
    assert np.array_equal(gx.transform_points(wrap(points), AFFINE), gx.transform_points(points, AFFINE))


@pytest.mark.parametrize("wrap", [ByInterface, ByDLPack])
def test_index_and_weights_may_be_such_arrays_too(wrap: Any) -> None:
    points, matrices = some_points(4, np.float32), np.array([AFFINE, np.eye(4)])
    index, weights = np.array([[0, 1]] * 4), np.array([[0.25, 0.75]] * 4)
    result = gx.transform_points(points, matrices, index=wrap(index), weights=wrap(weights))
    assert np.array_equal(result, gx.transform_points(points, matrices, index=index, weights=weights))


def test_an_array_of_numpys_own_is_not_copied_and_a_map_stays_one(tmp_path: Any) -> None:
    points = some_points(9, np.float32)
    assert as_host_array(points, "points") is points
    np.save(tmp_path / "points.npy", points)
    assert isinstance(as_host_array(np.load(tmp_path / "points.npy", mmap_mode="r"), "points"), np.memmap)


def test_memory_of_another_device_is_refused() -> None:
    tensor: Any = Elsewhere(some_points(4, np.float32))
    with pytest.raises(ArgumentTypeError, match="points must be in the host's memory: the array is on cuda:0"):
        gx.transform_points(tensor, AFFINE)
