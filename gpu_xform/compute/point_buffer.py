"""Point buffers: points that stay on the device between one transform and the next."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, require_affine
from .._core.masked import drop_hidden_rows
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..device import Device, resolve_device
from ..errors import ArgumentError
from ._arrays import as_4x4, as_point_array, require_output
from ._precision import require_range, resolve_precision
from .backend import PointStore, find_backend
from .kernels.job import Epilogue
from .kernels.reduction import Reduction

if TYPE_CHECKING:
    from ..gpu.device_points import DevicePoints


@public
class PointBuffer:
    """An array of points in the device's memory, and the transforms that are still to be applied to it.

    `transformed` and `projected` only multiply matrices, in float64: a chain of any length is one dispatch, which runs
    when the result is read. What they return shares the device's memory with the buffer it came from, and stays valid
    until that is closed. A PointBuffer is a context manager that closes itself.

    Parameters
    ----------
    points : (n, 3) or (n, 2)
        float32, float64, integers or float16; uploaded once. Rows that a mask hides are left out.
    device : Device, optional
        By default the process's own.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        As `transform_points` does.
    PrecisionError
        For float64 points on a device without double precision.
    """

    def __init__(self, points: npt.ArrayLike, *, device: Device | None = None) -> None:
        source = as_point_array(drop_hidden_rows(points))
        if source.ndim != 2:
            raise ArgumentError.expecting("points", "have shape (n, 3) or (n, 2)", source.shape)
        device = resolve_device(device)
        dtype = resolve_precision("float64" if source.dtype.itemsize == 8 else "float32", source.dtype, device).dtype
        self._store: PointStore = find_backend(device).store_points(device, source, dtype)
        self._pending: Float64Array | None = None
        self._divides = False

    @property
    def device(self) -> Device:
        """The device that holds the points."""
        return self._store.device

    @property
    def dtype(self) -> np.dtype[Any]:
        """float32 or float64."""
        return self._store.dtype

    @property
    def shape(self) -> tuple[int, int]:
        """(n, 3) or (n, 2)."""
        return self._store.shape

    @property
    def nbytes(self) -> int:
        """The bytes of the points, as NumPy would count them."""
        return self._store.shape[0] * self._store.shape[1] * self._store.dtype.itemsize

    def __len__(self) -> int:
        return self._store.shape[0]

    @property
    def pending(self) -> Float64Array | None:
        """The (4, 4) matrix that is still to be applied, for points of the plane with an idle z; or None."""
        return None if self._pending is None else as_4x4(self._pending[None])[0]

    def transformed(self, matrix: MatrixLike) -> Self:
        """Return the points with an affine matrix to be applied after what is pending.

        Parameters
        ----------
        matrix : (4, 4) for points of space, (3, 3) for points of the plane, or an object with `as_matrix()`
            Affine: the last row is (0, ..., 0, 1).

        Returns
        -------
        PointBuffer
            It shares the device's memory with this one.

        Raises
        ------
        ArgumentError
            For a matrix that is not affine or has another shape, and for a product that the points' type cannot hold.
        """
        affine = as_square_matrix(matrix, "matrix", self.shape[1] + 1)
        require_affine(affine, "matrix")
        return self._then(affine, self._divides)

    def projected(self, matrix: MatrixLike) -> Self:
        """Return the points with any matrix to be applied after what is pending; the result is divided by w.

        Parameters
        ----------
        matrix : (4, 4) for points of space, (3, 3) for points of the plane, or an object with `as_matrix()`
            The one division by w comes after the last matrix of the chain.

        Returns
        -------
        PointBuffer
            It shares the device's memory with this one.

        Raises
        ------
        ArgumentError
            For a matrix of another shape, and for a product that the points' type cannot hold.
        """
        return self._then(as_square_matrix(matrix, "matrix", self.shape[1] + 1), True)

    def numpy(self, out: npt.NDArray[Any] | None = None) -> npt.NDArray[Any]:
        """Return the points after all transforms, as a NumPy array.

        Parameters
        ----------
        out : array, optional
            Where to write them: an array of the buffer's shape and dtype.

        Returns
        -------
        array, (n, 3) or (n, 2)
            `out`, or a new array.

        Raises
        ------
        ArgumentError, ArgumentTypeError
            If `out` has another shape or dtype.
        DeviceError
            If the buffer or its device is closed.
        """
        if out is None:
            out = np.empty(self.shape, self.dtype)
        else:
            require_output(out, self.shape, np.empty((0, 0), self.dtype))
        self._store.download(self.pending, self._epilogue, out)
        return out

    def bounds(self) -> npt.NDArray[Any]:
        """Return the smallest and the largest coordinates after all transforms.

        Returns
        -------
        array, (2, 3) or (2, 2)
            Of the buffer's dtype; an axis on which a coordinate is NaN is NaN.

        Raises
        ------
        ArgumentError
            If there are no points.
        DeviceError
            If the buffer or its device is closed.
        """
        reduction = self._reduce()
        return np.stack([reduction.lowest, reduction.highest]).astype(self.dtype)

    def centroid(self) -> Float64Array:
        """Return the mean of the points after all transforms.

        Returns
        -------
        array, (3,) or (2,) float64

        Raises
        ------
        ArgumentError
            If there are no points.
        DeviceError
            If the buffer or its device is closed.
        """
        reduction = self._reduce()
        return reduction.total / reduction.n_points

    def device_points(self) -> DevicePoints:
        """Return the points as they lie on the device, without what is pending, for a stage that draws them there."""
        return self._store.device_points()

    def close(self) -> None:
        """Give the device's memory back, for every buffer that shares it. Closing twice does nothing.

        What nobody refers to any more is given back as well, but only by the next work on a device.
        """
        self._store.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        if copy is False:
            raise ValueError("the points are in the device's memory: an array of them is always a copy")
        return np.asarray(self.numpy(), dtype)

    def __repr__(self) -> str:
        return f"<PointBuffer: {self.shape[0]} x {self.shape[1]} {self.dtype} on {self.device.name!r}>"

    def _then(self, matrix: Float64Array, divides: bool) -> Self:
        result = self.__new__(type(self))
        result._store = self._store
        with np.errstate(over="ignore", invalid="ignore"):
            result._pending = matrix if self._pending is None else matrix @ self._pending
        require_range(result._pending, self.dtype)
        result._divides = divides
        return result

    @property
    def _epilogue(self) -> Epilogue:
        return Epilogue.PERSPECTIVE_DIVIDE if self._divides else Epilogue.NONE

    def _reduce(self) -> Reduction:
        if len(self) == 0:
            raise ArgumentError.expecting("points", "hold at least one point to have bounds or a centroid", "none")
        return self._store.reduce(self.pending, self._epilogue)


@public
def bounds(points: npt.ArrayLike, *, device: Device | None = None) -> npt.NDArray[Any]:
    """Return the smallest and the largest coordinates of `points`, found on the device.

    Parameters
    ----------
    points : (n, 3) or (n, 2), n > 0
        float32, float64, integers or float16. Rows that a mask hides do not count.
    device : Device, optional
        By default the process's own.

    Returns
    -------
    array, (2, 3) or (2, 2)
        Of the dtype of the points; an axis on which a coordinate is NaN is NaN.

    Raises
    ------
    ArgumentError, ArgumentTypeError, PrecisionError
        As `PointBuffer` does; `ArgumentError` also if there are no points.
    """
    with PointBuffer(points, device=device) as buffer:
        return buffer.bounds()
