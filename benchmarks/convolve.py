"""Convolution beside its peers: each output is checked before its time counts, ratios come from one run.

The peers come with `pip install 'gpu_xform[bench]'`. All take NumPy arrays and give new ones, 4096 x 4096 pixels, with
the border that NumPy calls "reflect".
"""

import argparse
import os
import platform
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from harness import Contender, Row, calm_threads, medians, table

import gpu_xform as gx
from gpu_xform.gpu.device import default_gpu_device

Pixels = npt.NDArray[Any]
Kernel = npt.NDArray[np.float64]

SIDE = 4096
OPENCV_THREADS = 2
# Of 255; a peer that accumulates in single precision may round a value next to the middle of two the other way.
MAX_UNEQUAL_BYTES = 1e-4


def per_channel(image: Pixels, filter_plane: Callable[[Pixels], Pixels]) -> Pixels:
    """Filter each channel by itself, for libraries that know planes alone."""
    if image.ndim == 2:
        return filter_plane(image)
    planes: Pixels = np.stack([filter_plane(image[..., k]) for k in range(image.shape[-1])], axis=-1)
    return planes


def peers(image: Pixels, kernel: Kernel, factors: tuple[Kernel, Kernel] | None) -> dict[str, Contender]:
    """Return the same filter by other libraries, each in the fastest way that its documentation offers."""
    import cv2
    from scipy import ndimage

    cv2.setNumThreads(OPENCV_THREADS)
    flipped = np.ascontiguousarray(kernel[::-1, ::-1]).astype(np.float32)
    if factors is None:
        contenders: dict[str, Contender] = {
            "OpenCV": lambda: cv2.filter2D(image, -1, flipped, borderType=cv2.BORDER_REFLECT_101)
        }

        def by_scipy(plane: Pixels) -> Pixels:
            # Integers are truncated, so that they are computed as floats and rounded.
            if plane.dtype == np.uint8:
                return np.asarray(np.rint(ndimage.convolve(plane, kernel, output=np.float32, mode="mirror")), np.uint8)
            return np.asarray(ndimage.convolve(plane, kernel, mode="mirror"))

        return contenders | {"scipy.ndimage": lambda: per_channel(image, by_scipy)}
    column, row = factors
    down, across = column[::-1].astype(np.float32), row[::-1].astype(np.float32)
    return {
        "OpenCV": lambda: cv2.sepFilter2D(image, -1, across, down, borderType=cv2.BORDER_REFLECT_101),
        "scipy.ndimage": lambda: ndimage.convolve1d(
            ndimage.convolve1d(image, row, axis=1, mode="mirror"), column, axis=0, mode="mirror"
        ),
    }


def pillow_peer(image: Pixels, kernel: Kernel) -> dict[str, Contender]:
    """Return Pillow's filter, which knows kernels of 3 x 3 and 5 x 5, and leaves the image's rim as it is.

    It flips kernels from top to bottom, and not from left to right.
    """
    from PIL import Image, ImageFilter

    weights = ImageFilter.Kernel(kernel.shape[::-1], kernel[:, ::-1].ravel().tolist(), scale=1)
    return {"Pillow": lambda: np.asarray(Image.fromarray(image).filter(weights))}


def fft_peer(image: Pixels, kernel: Kernel) -> dict[str, Contender]:
    """Return SciPy's convolution by Fourier transforms, which pads with zeros."""
    from scipy import signal

    single = kernel.astype(image.dtype)
    return {"SciPy fftconvolve": lambda: signal.fftconvolve(image, single, mode="same")}


def checked(contenders: dict[str, Contender], expected: Pixels, margin: int) -> dict[str, Contender]:
    """Return the contenders; stop where one computes something else further than `margin` from the sides."""
    inner = slice(margin, -margin or None)
    for name, run in contenders.items():
        result = np.asarray(run())
        if result.dtype != expected.dtype or result.shape != expected.shape:
            raise SystemExit(f"{name} gives {result.dtype} {result.shape}: not compared")
        difference = np.abs(result[inner, inner].astype(np.float32) - expected[inner, inner])
        if expected.dtype == np.uint8:
            if difference.max() > 1 or np.count_nonzero(difference) > MAX_UNEQUAL_BYTES * difference.size:
                raise SystemExit(f"{name} is off by {difference.max()} in {np.count_nonzero(difference)} bytes")
        elif not difference.max() <= 2e-5:
            raise SystemExit(f"{name} is off by {difference.max()}: not compared")
    return contenders


def compare(
    what: str, image: Pixels, kernel: Any, asked: dict[str, float | None], rounds: int = 5, **keywords: Any
) -> list[Row]:
    """Return a row for each peer that `asked` names."""
    factors = kernel if isinstance(kernel, tuple) else None
    matrix = np.outer(*factors) if factors else kernel
    ours: dict[str, Contender] = {"ours": lambda: gx.convolve(image, kernel, **keywords)}
    expected = np.asarray(ours["ours"]())
    contenders = dict(checked(ours, expected, 0))
    if {"OpenCV", "scipy.ndimage"} & asked.keys():
        contenders |= checked({n: c for n, c in peers(image, matrix, factors).items() if n in asked}, expected, 0)
    if "Pillow" in asked:
        contenders |= checked(pillow_peer(image, matrix), expected, len(matrix) // 2)
    if "SciPy fftconvolve" in asked:
        contenders |= checked(fft_peer(image, matrix), expected, len(matrix) // 2)
    seconds = medians(contenders, rounds=rounds, warm_up=1)
    return [Row(what, name, seconds["ours"], seconds[name], asked[name]) for name in contenders if name in asked]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=SIDE, help="pixels of a side of the images")
    parser.add_argument("--only", default="", help="measure the rows whose name contains this")
    parser.add_argument("--host", action="store_true", help="the rows of the host device, beside OpenCV")
    parser.add_argument("--rounds", type=int, default=5, help="in which the contenders take turns (%(default)s)")
    arguments = parser.parse_args()
    calm_threads()
    rng = np.random.default_rng(1)
    shape = (arguments.side, arguments.side)
    floats, rgba = rng.random(shape, np.float32), rng.integers(0, 256, (*shape, 4), np.uint8)

    def dense(n: int) -> Kernel:
        kernel = rng.random((n, n))
        kernel /= kernel.sum()
        return kernel

    gaussian = gx.gaussian(31 / 8, truncate=15 / (31 / 8))
    cases: list[tuple[str, Pixels, Any, dict[str, float | None]]] = [
        ("float32, 3 x 3", floats, dense(3), {"scipy.ndimage": 0.5, "OpenCV": 2.5}),
        ("float32, 7 x 7", floats, dense(7), {"scipy.ndimage": 0.25, "OpenCV": 2.5}),
        ("float32, 31 separable", floats, gaussian, {"scipy.ndimage": 0.35, "OpenCV": 3.0}),
        ("float32, 31 x 31", floats, dense(31), {"SciPy fftconvolve": 1.2, "OpenCV": None}),
        ("RGBA uint8, 3 x 3", rgba, dense(3), {"scipy.ndimage": 0.25, "Pillow": 0.3, "OpenCV": None}),
        ("RGBA uint8, 5 x 5", rgba, dense(5), {"Pillow": 0.3}),
        ("RGBA uint8, 7 x 7", rgba, dense(7), {"scipy.ndimage": 0.25, "OpenCV": 1.5}),
        ("RGBA uint8, 15 x 15", rgba, dense(15), {"OpenCV": 1.0}),
    ]
    device = gx.Device("host") if arguments.host else default_gpu_device()
    if arguments.host:
        cases = [(what, image, kernel, {"OpenCV": 1.3}) for what, image, kernel, asked in cases if "OpenCV" in asked]
    print(f"{device!r}; Python {platform.python_version()}, NumPy {np.__version__}, {os.cpu_count()} CPUs")
    rows = []
    for what, image, kernel, asked in cases:
        if arguments.only in what:
            rows += compare(what, image, kernel, asked, arguments.rounds, alpha="independent", device=device)
    if arguments.only in "RGBA uint8, 7 x 7, premultiplied":
        kernel = dense(7)
        seconds = medians(
            {
                "premultiplied": lambda: gx.convolve(rgba, kernel, device=device),
                "independent": lambda: gx.convolve(rgba, kernel, alpha="independent", device=device),
            },
            rounds=5,
            warm_up=1,
        )
        rows.append(Row("RGBA uint8, 7 x 7, premultiplied", "own, independent", *seconds.values()))
    print(table(rows))


if __name__ == "__main__":
    main()
