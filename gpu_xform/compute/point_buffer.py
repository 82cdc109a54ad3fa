"""Points that stay on the device between one transform and the next."""

from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, require_affine
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..errors import ArgumentError, DeviceError
from ..gpu.buffers import Buffer
from ..gpu.chunking import DispatchPlan
from ..gpu.device import Device, resolve_device
from ..gpu.device_points import DevicePoints
from ._arrays import as_4x4, as_point_array, require_output
from ._precision import require_range, resolve
from .kernels import reduce as reduce_pass
from .kernels import transform as transform_pass
from .kernels.transform import POOL_OWNER, Finish


@public
class PointBuffer:
    """An array of points in the device's memory, and the transforms it has still to go through.

    `transformed` and `projected` only multiply matrices, in float64: a chain of any length is one dispatch, when the
    result is asked for. What they return shares the device's memory with the buffer it came from, and stays valid until
    that is closed.

    points : (n, 3) or (n, 2), float32 or float64; uploaded once
    device : by default the process's own

    Raises as `transform_points` does; `PrecisionError` for float64 points on a device without it.
    """

    def __init__(self, points: npt.ArrayLike, *, device: Device | None = None) -> None:
        source = as_point_array(points)
        if source.ndim != 2:
            raise ArgumentError.expecting("points", "have shape (n, 3) or (n, 2)", source.shape)
        device = resolve_device(device)
        dtype = resolve("float64" if source.dtype.itemsize == 8 else "float32", source.dtype, device).dtype
        self._store = _Store(device, source, dtype)
        self._pending: Float64Array | None = None
        self._divides = False

    @property
    def device(self) -> Device:
        """The device that holds the points."""
        return self._store.plan.device

    @property
    def dtype(self) -> np.dtype[Any]:
        """float32 or float64."""
        return self._store.plan.dtype

    @property
    def shape(self) -> tuple[int, int]:
        """(n, 3) or (n, 2)."""
        return self._store.n_points, self._store.plan.n_components

    @property
    def nbytes(self) -> int:
        """The bytes of the points, as NumPy would count them."""
        return self._store.n_points * self._store.plan.point_bytes

    def __len__(self) -> int:
        return self._store.n_points

    @property
    def pending(self) -> Float64Array | None:
        """The (4, 4) matrix that the points have still to go through, for points of R^2 with an idle z; or None."""
        return None if self._pending is None else as_4x4(self._pending[None])[0]

    def transformed(self, matrix: MatrixLike) -> "PointBuffer":
        """Return the points with an affine matrix to be applied after what is pending."""
        affine = as_square_matrix(matrix, "matrix", self.shape[1] + 1)
        require_affine(affine, "matrix")
        return self._followed_by(affine, self._divides)

    def projected(self, matrix: MatrixLike) -> "PointBuffer":
        """Return the points with any matrix to be applied after what is pending; the result is divided by w."""
        return self._followed_by(as_square_matrix(matrix, "matrix", self.shape[1] + 1), True)

    def numpy(self, out: npt.NDArray[Any] | None = None) -> npt.NDArray[Any]:
        """Return the points as they are after all transforms: (n, 3) or (n, 2), in `out` where one is given."""
        if out is None:
            out = np.empty(self.shape, self.dtype)
        else:
            require_output(out, self.shape, np.empty((0, 0), self.dtype))
        self._store.download(self.pending, self._finish, out)
        return out

    def bounds(self) -> npt.NDArray[Any]:
        """Return the smallest and the largest coordinates: (2, 3) or (2, 2), of the own dtype; NaN where one is."""
        reduction = self._reduced()
        return np.stack([reduction.lowest, reduction.highest]).astype(self.dtype)

    def centroid(self) -> Float64Array:
        """Return the mean of the points: (3,) or (2,) float64."""
        reduction = self._reduced()
        return reduction.total / reduction.n_points

    def device_points(self) -> DevicePoints:
        """Return the points on the device, without what is pending, for a stage that draws them from there."""
        return self._store.device_points()

    def close(self) -> None:
        """Give the device's memory back, for every buffer that shares it. Closing twice does nothing."""
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

    def _followed_by(self, matrix: Float64Array, divides: bool) -> "PointBuffer":
        follower = PointBuffer.__new__(PointBuffer)
        follower._store = self._store
        with np.errstate(over="ignore", invalid="ignore"):
            follower._pending = matrix if self._pending is None else matrix @ self._pending
        require_range(follower._pending, self.dtype)
        follower._divides = divides
        return follower

    @property
    def _finish(self) -> Finish:
        return Finish.DIVIDED_BY_W if self._divides else Finish.AS_IT_IS

    def _reduced(self) -> reduce_pass.Reduction:
        if len(self) == 0:
            raise ArgumentError.expecting("points", "hold at least one point to have bounds or a centroid", "none")
        return self._store.reduce(self.pending, self._finish)


@public
def bounds(points: npt.ArrayLike, *, device: Device | None = None) -> npt.NDArray[Any]:
    """Return the smallest and the largest coordinates of `points`, found on the device.

    points : (n, 3) or (n, 2), n > 0; the result is (2, 3) or (2, 2), of the same dtype; NaN where a coordinate is

    Raises as `PointBuffer` does, and `ArgumentError` for no points.
    """
    with PointBuffer(points, device=device) as buffer:
        return buffer.bounds()


class _Store:
    """The device's memory behind one `PointBuffer` and all that came from it."""

    def __init__(self, device: Device, points: npt.NDArray[Any], dtype: np.dtype[Any]) -> None:
        n_points, n_components = points.shape
        self.n_points: int = n_points
        self.plan = DispatchPlan.of(device, max(self.n_points, 1), n_components, dtype)
        self.parts: list[tuple[slice, Buffer]] = []
        self._released = False
        try:
            for part in self.plan.chunks(self.n_points):
                buffer = Buffer(
                    device.context,
                    self.plan.padded(part.stop - part.start) * self.plan.point_bytes,
                    label="PointBuffer",
                )
                self.parts.append((part, buffer))
                buffer.upload(np.ascontiguousarray(points[part], dtype))
        except BaseException:
            self.release()
            raise

    def download(self, matrix: Float64Array | None, finish: Finish, out: npt.NDArray[Any]) -> None:
        device = self.require_open()
        for part, source in self.parts:
            with device.lock:
                result = source
                if matrix is not None:
                    result = device.pool.scratch(POOL_OWNER, "destination", source.n_bytes)
                    transform_pass.apply(self.plan, matrix[None], source, result, part.stop - part.start, finish)
                transform_pass.download_rows(self.plan, result, out[None, part])

    def reduce(self, matrix: Float64Array | None, finish: Finish) -> reduce_pass.Reduction:
        self.require_open()
        parts = [
            reduce_pass.reduce(self.plan, source, part.stop - part.start, matrix, finish) for part, source in self.parts
        ]
        whole = parts[0]
        for part in parts[1:]:
            whole = whole.merged(part)
        return whole

    def device_points(self) -> DevicePoints:
        device = self.require_open()
        if len(self.parts) != 1:
            raise ArgumentError.expecting(
                "points", f"be one to {self.plan.chunk:,} to be drawn from {device.name!r}", f"{self.n_points:,}"
            )
        return DevicePoints(self.parts[0][1], self.n_points, self.plan.dtype)

    def require_open(self) -> Device:
        if self._released:
            raise DeviceError("the PointBuffer is closed")
        self.plan.device.require_usable()
        return self.plan.device

    def release(self) -> None:
        self._released = True
        for _, buffer in self.parts:
            buffer.release()

    def __del__(self) -> None:
        self.release()
