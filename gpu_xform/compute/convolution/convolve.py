"""Convolution and correlation of images, on the device.

Accuracy, with s = sum |kernel| max |image|: float32 results lie within 6e-7 s of the exact ones, float64 ones
within 1e-15 s. Integers are the exact results, rounded to the nearest, ties to even, and clamped; at most one in
50,000 is off by 1, which then lies next to the middle of two integers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args, overload

import numpy as np
import numpy.typing as npt

from ..._core.arguments import require_flag, require_text
from ..._core.public import public
from ..._core.suggestions import did_you_mean
from ...device import Device, resolve_device
from ...errors import ArgumentError, ArgumentTypeError, PrecisionError
from .._precision import DOUBLE, SINGLE
from ..backend import find_backend
from ..kernels.convolution_job import MAX_CHANNELS, ConvolutionJob, Stencil
from .borders import Border, Extension
from .fourier import choose_fourier, correlate_by_fourier
from .pixels import N_RGBA, RGB, ImageLike, Images, opaque_alpha, read_images
from .stencils import Kernel, KernelLike, OneKernel, Origin, SomeKernel, as_integers, read_kernels, split
from .transfer import decode, encode

if TYPE_CHECKING:
    from PIL.Image import Image

Alpha = Literal["premultiplied", "independent", "keep"]


@dataclass(frozen=True)
class _Options:
    """The keywords that both functions share, as they were given."""

    border: Border
    origin: Origin | None
    stack: bool
    alpha: Alpha
    linear: bool
    out: Any
    device: Device | None


# A list of arrays or pairs is also array-like, and means several kernels.
@overload
def convolve(
    image: Image,
    kernel: list[SomeKernel],
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: None = None,
    device: Device | None = None,
) -> list[Image]: ...


@overload
def convolve(
    image: Image,
    kernel: OneKernel,
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: None = None,
    device: Device | None = None,
) -> Image: ...


@overload
def convolve(
    image: npt.ArrayLike,
    kernel: list[SomeKernel],
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: list[npt.NDArray[Any]] | None = None,
    device: Device | None = None,
) -> list[npt.NDArray[Any]]: ...


@overload
def convolve(
    image: npt.ArrayLike,
    kernel: OneKernel,
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]: ...


@public
def convolve(
    image: ImageLike,
    kernel: KernelLike,
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: npt.NDArray[Any] | list[npt.NDArray[Any]] | None = None,
    device: Device | None = None,
) -> Any:
    """Convolve an image with a kernel: every pixel becomes a weighted sum of its neighbours.

    out[y, x] = sum_ij kernel[i, j] image[y + r - i, x + c - j], with (r, c) the origin: the kernel is flipped, so that
    the image of one white pixel is the kernel itself. `correlate` does not flip.

    Other libraries differ. `scipy.ndimage.convolve` flips as well, truncates integers and lets them wrap (200 + 200
    gives 144), calls borders otherwise ("mirror" is "reflect" here, "reflect" is "symmetric", "nearest" is "edge"), and
    its `origin` is an offset from the middle. OpenCV's `filter2D` correlates, and puts the middle of an even side
    elsewhere; Pillow's `ImageFilter.Kernel` flips from top to bottom alone, and leaves the image's rim as it is; both
    filter alpha as if it were a colour. `scipy.signal.convolve2d` pads with
    zeros.

    Parameters
    ----------
    image : (h, w) or (h, w, c) array, or a Pillow image
        float32, float64, uint8 or uint16, or mode L, LA, RGB, RGBA, I;16 or F. Row 0 is at the top.
    kernel : (m, n) array, (column, row), (c, m, n), or a list of these
        One matrix for all channels; two 1-D arrays, of which it is the product; one matrix per channel. A list of
        arrays and pairs gives a list of results.
    border : {"reflect", "symmetric", "edge", "wrap", "constant"}
        How the image goes on beyond its sides, as in `numpy.pad`; "constant" is zero.
    origin : (row, column), optional
        Which entry of the kernel stands at the pixel itself; the middle, if both sides are odd.
    stack : bool
        The array is a stack (k, h, w) or (k, h, w, c) of images.
    alpha : {"premultiplied", "independent", "keep"}
        Of four channels the last is alpha. By default colours are weighted by it, and divided by the result, clamped to
        opaque: what is transparent lends no colour. "independent" treats it as another channel; "keep" leaves it as it
        is, and treats colours alone. With a kernel per channel, "independent" is the default.
    linear : bool
        The values are sRGB: filter the light that they stand for, and encode it again.
    out : array, optional
        Where to write the result: an array of the image's shape and dtype, which may be the image itself; a list of
        arrays for a list of kernels.
    device : Device, optional
        By default the process's own.

    Returns
    -------
    array or Pillow image, or a list of them
        Of the image's shape and type. Integers are rounded to the nearest, ties to even, and clamped.

    Raises
    ------
    ArgumentError
        "image must have shape (h, w) or (h, w, c), got (4,)"; for a kernel that is empty or not finite, that has
        an even side and no origin, whose sum is not positive where it is to weight alpha, or that reaches farther
        beyond the image than "reflect", "symmetric" or "wrap" can tell; for other arguments likewise.
    ArgumentTypeError
        For images of other types.
    PrecisionError
        For float64 on a device without it.
    """
    return _run(image, kernel, _Options(border, origin, stack, alpha, linear, out, device), flips=True)


@overload
def correlate(
    image: Image,
    kernel: list[SomeKernel],
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: None = None,
    device: Device | None = None,
) -> list[Image]: ...


@overload
def correlate(
    image: Image,
    kernel: OneKernel,
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: None = None,
    device: Device | None = None,
) -> Image: ...


@overload
def correlate(
    image: npt.ArrayLike,
    kernel: list[SomeKernel],
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: list[npt.NDArray[Any]] | None = None,
    device: Device | None = None,
) -> list[npt.NDArray[Any]]: ...


@overload
def correlate(
    image: npt.ArrayLike,
    kernel: OneKernel,
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]: ...


@public
def correlate(
    image: ImageLike,
    kernel: KernelLike,
    *,
    border: Border = "reflect",
    origin: Origin | None = None,
    stack: bool = False,
    alpha: Alpha = "premultiplied",
    linear: bool = False,
    out: npt.NDArray[Any] | list[npt.NDArray[Any]] | None = None,
    device: Device | None = None,
) -> Any:
    """Correlate an image with a kernel: `convolve` with a kernel that is not flipped, what OpenCV's `filter2D` does.

    out[y, x] = sum_ij kernel[i, j] image[y + i - r, x + j - c], with (r, c) the origin.

    Parameters
    ----------
    image : (h, w) or (h, w, c) array, or a Pillow image
        float32, float64, uint8 or uint16, or mode L, LA, RGB, RGBA, I;16 or F. Row 0 is at the top.
    kernel : (m, n) array, (column, row), (c, m, n), or a list of these
        As in `convolve`, where the other keywords are described too.
    border : {"reflect", "symmetric", "edge", "wrap", "constant"}
        How the image goes on beyond its sides, as in `numpy.pad`.
    origin : (row, column), optional
        Which entry of the kernel stands at the pixel itself.
    stack : bool
        The array is a stack of images.
    alpha : {"premultiplied", "independent", "keep"}
        What becomes of the last of four channels.
    linear : bool
        Filter the light that sRGB values stand for.
    out : array, optional
        Where to write the result.
    device : Device, optional
        By default the process's own.

    Returns
    -------
    array or Pillow image, or a list of them
        Of the image's shape and type.

    Raises
    ------
    ArgumentError, ArgumentTypeError, PrecisionError
        As `convolve` does.
    """
    return _run(image, kernel, _Options(border, origin, stack, alpha, linear, out, device), flips=False)


def _run(image: ImageLike, kernel: object, options: _Options, *, flips: bool) -> Any:
    """Check everything, and compute a result per kernel."""
    require_flag(options.linear, "linear")
    require_text(options.alpha, "alpha")
    images = read_images(image, stack=options.stack)
    kernels, is_list = read_kernels(kernel, options.origin)
    if flips:
        kernels = [each.flipped() for each in kernels]
    if options.alpha not in get_args(Alpha):
        hint = did_you_mean(str(options.alpha), get_args(Alpha))
        raise ArgumentError.expecting("alpha", f"be one of {', '.join(get_args(Alpha))}", f"{options.alpha!r}{hint}")
    extension = Extension(options.border)
    for each in kernels:
        _require_suitable(each, images.pixels, options.alpha)
        extension.require_wide_enough(images.pixels.shape[1:3], next(each.stencils))
    outs = _outputs(images, options.out, len(kernels), is_list=is_list)
    device = resolve_device(options.device)
    if images.pixels.dtype == DOUBLE and not device.has_float64:
        raise PrecisionError(f"{device.name!r} has no double precision (shader-f64): convert the image to float32")
    source = decode(images.pixels) if options.linear and images.pixels.size else images.pixels
    for each, out in zip(kernels, outs, strict=True):
        _filter(source, each, out, extension, options, device)
    results = [images.restore(out) for out in outs] if options.out is None else _as_list(options.out, is_list=is_list)
    return results if is_list else results[0]


def _as_list(value: Any, *, is_list: bool) -> list[Any]:
    return list(value) if is_list else [value]


def _require_suitable(kernel: Kernel, pixels: npt.NDArray[Any], alpha: Alpha) -> None:
    n_channels = pixels.shape[-1]
    if len(kernel.matrices) > 1:
        if len(kernel.matrices) != n_channels:
            expected = f"have one matrix, or one for each of {n_channels} channels"
            raise ArgumentError.expecting("kernel", expected, len(kernel.matrices))
    elif n_channels == N_RGBA and alpha == "premultiplied" and kernel.matrices.sum() <= 0.0:
        expected = "have a positive sum if colours are weighted by alpha: alpha='keep' leaves it as it is"
        raise ArgumentError.expecting("kernel", expected, f"{kernel.matrices.sum():g}")


def _outputs(images: Images, out: Any, n_kernels: int, *, is_list: bool) -> list[npt.NDArray[Any]]:
    """Return the arrays (k, h, w, c) to write into."""
    pixels = images.pixels
    if out is None:
        return [np.empty(pixels.shape, pixels.dtype) for _ in range(n_kernels)]
    if images.picture is not None:
        raise ArgumentError("out is for arrays: the result of a Pillow image is a new one")
    if is_list and not (isinstance(out, list) and len(out) == n_kernels):
        raise ArgumentError.expecting("out", f"be a list of {n_kernels} arrays, as there are kernels")
    for each in _as_list(out, is_list=is_list):
        if not isinstance(each, np.ndarray):
            raise ArgumentTypeError.expecting("out", "be a NumPy array", type(each).__name__)
        if each.shape != images.shape:
            raise ArgumentError.expecting("out", f"have shape {images.shape}", each.shape)
        if each.dtype != pixels.dtype:
            raise ArgumentTypeError.expecting("out", f"have dtype {pixels.dtype}", each.dtype)
        if not each.flags.writeable:
            raise ArgumentError.expecting("out", "be writeable", "a read-only array")
    return [_as_pixels(each, images) for each in _as_list(out, is_list=is_list)]


def _as_pixels(array: npt.NDArray[Any], images: Images) -> npt.NDArray[Any]:
    """Return an array of the caller's shape as one (k, h, w, c), sharing its memory."""
    view = array if array.ndim == images.pixels.ndim else array[None]
    return view if view.ndim == images.pixels.ndim and view.shape == images.pixels.shape else view[..., None]


def _filter(
    source: npt.NDArray[Any],
    kernel: Kernel,
    out: npt.NDArray[Any],
    extension: Extension,
    options: _Options,
    device: Device,
) -> None:
    """Write the images `source` (k, h, w, c), correlated with a kernel, into `out`."""
    if source.size == 0:
        return
    alpha = options.alpha
    is_own = not (options.linear or np.may_share_memory(source, out))
    target = out if is_own else np.empty(source.shape, source.dtype)
    n_channels = source.shape[-1]
    is_shared = len(kernel.matrices) == 1
    if alpha == "keep" and n_channels == N_RGBA:
        target[..., 3] = source[..., 3]
        groups = [RGB] if is_shared else [slice(k, k + 1) for k in range(3)]
    elif is_shared and n_channels <= MAX_CHANNELS:
        groups = [slice(0, n_channels)]
    else:
        groups = [slice(k, k + 1) for k in range(n_channels)]
    is_premultiplied = alpha == "premultiplied" and is_shared and n_channels == N_RGBA
    opaque = opaque_alpha(source.dtype) if is_premultiplied else 0.0
    for number, group in enumerate(groups):
        one = kernel if is_shared else Kernel(kernel.matrices[[number]], None, kernel.origin)
        _correlate(source[..., group], one, target[..., group], extension, opaque, device)
    if options.linear:
        encode(target, out)
    elif target is not out:
        out[...] = target


def _correlate(
    images: npt.NDArray[Any],
    kernel: Kernel,
    out: npt.NDArray[Any],
    extension: Extension,
    opaque: float,
    device: Device,
) -> None:
    """Correlate with a kernel that has one matrix."""
    is_integer = images.dtype.kind == "u"
    dtype = DOUBLE if images.dtype in (DOUBLE, np.uint16) and device.has_float64 else SINGLE
    stencils: tuple[Stencil, ...] = split(kernel, dtype.itemsize)
    if not opaque and len(stencils) == 1 and choose_fourier(images, stencils[0], device, dtype):
        correlate_by_fourier(images, out, stencils[0], extension, dtype)
        return
    scale = 1.0
    if is_integer:
        stencils, scale = as_integers(stencils, np.iinfo(images.dtype).max * max(opaque, 1.0), dtype)
    find_backend(device).run_convolution(ConvolutionJob(device, images, out, stencils, extension, dtype, scale, opaque))
