"""Models in motion: drawn frame by frame, and saved in any format that shows them moving."""

import contextlib
import io
import os
from collections.abc import Generator, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_int, as_unit_vector
from .._core.error_context import prefix_errors
from .._core.progress import show_progress
from .._core.public import public
from .._core.types import Float64Array, MatrixLike, Progress, StrPath
from ..drawing.camera import Camera, CameraLike, extreme_points, fit_options, require_in_range
from ..drawing.framing import framing_points
from ..drawing.layer import Layer, Models, Style
from ..drawing.load_models import load_models
from ..drawing.prepare import Frame, Size, parse_size
from ..errors import ArgumentError, MeshError
from ..gpu.device import Device
from ..imaging import image as images
from ..imaging.colors import ColorLike, rgba
from ..imaging.image import Pixels
from ..matrices import rotate, translate
from ..raster.base import PendingImage
from ..rendering.raster import begin_render
from . import poses
from .encoders import html
from .encoders.frames import Clip
from .encoders.registry import saver
from .motion import Frames, Motion, described, frame_count

if TYPE_CHECKING:
    from PIL.Image import Image

DEFAULT_SIZE = (640, 480)
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@public
def animate(
    models: Models,
    frames: Frames,
    path: StrPath | None = None,
    *,
    n_frames: int | None = None,
    duration: float | None = None,
    fps: float = 20,
    size: Size = DEFAULT_SIZE,
    camera: CameraLike | None = None,
    background: ColorLike | None = "white",
    device: Device | None = None,
    progress: Progress | None = None,
    **style: Unpack[Style],
) -> "Animation":
    """Return an animation of models; nothing is drawn before a frame, or a file, is asked for.

    models : as `render` takes them: a Mesh, an array of points (n, 3), the path of a model file, a PointBuffer, a
        Layer, a Scene, or several
    frames : for each frame the (4, 4) matrix that moves the models, or a dict from names of a scene's nodes to their
        matrices, or another model in their place, an array of points as `Mesh(points)`: several of them, a stack
        (k, 4, 4), a stack of SciPy's rotations; or a function that gives one
    path : where to save it at once, as `Animation.save` does
    n_frames : for a function, which is called with the frame's number, from 0 on
    duration : in place of n_frames, for a function that is called with the frame's time; both in seconds
    fps : frames a second
    size : (width, height) in pixels
    camera : by default one `Camera.fit` for all frames, which holds the models in each of them; a dict of its
        keywords, such as {"direction": (0, 0, -1)}, says how
    background : a colour, or None for transparent
    device : by default the process's own
    progress : called with the frames drawn and the frames in all while the file is written; by default a bar appears
        after a second, on a terminal only
    style : as `render` takes it; the matrix of a frame comes after `transform`

    A function is called again for the same frame, and must give the same. Raises `ArgumentError` for no frames, for a
    frame that is no matrix, and with the frame's number where a function raises; otherwise as `render` and
    `Animation.save` do.
    """
    moving = described(frames, fps, n_frames, duration)
    animation = Animation(load_models(models), moving, size, camera, background, device, style)
    if path is not None:
        animation.save(path, progress=progress)
    return animation


@public
def turntable(
    models: Models,
    frames: int = 100,
    path: StrPath | None = None,
    *,
    axis: str | npt.ArrayLike = "y",
    transform: MatrixLike | None = None,
    **options: Any,
) -> "Animation":
    """Return an animation of models that turn once, about an axis through the middle of their bounds.

    models : as `animate` takes them
    frames : how many; the last is one step short of the first, so that it goes round without a stop
    axis : "x", "y", "z" or a vector (3,), from whose end the turn is seen counter-clockwise
    transform : (4, 4), applied to the models before they turn
    options : further keywords of `animate`
    """
    count = frame_count(frames, "frames")
    if isinstance(axis, str) and axis not in AXES:
        raise ArgumentError.expecting("axis", "be 'x', 'y', 'z' or a vector", repr(axis))
    along = as_unit_vector(AXES[axis] if isinstance(axis, str) else axis, "axis", 3)
    shown = load_models(models)
    placed: Style = {} if transform is None else {"transform": transform}
    points = framing_points(poses.posed(shown, np.eye(4), placed))
    if len(points) == 0:
        raise MeshError("a model without points cannot turn about its middle")
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    to_middle, from_middle = translate(*-middle), translate(*middle)

    def turned(k: int) -> Float64Array:
        return from_middle @ rotate(along, 360.0 * k / count, degrees=True) @ to_middle

    return animate(shown, turned, path, n_frames=count, **placed, **options)


@public
class Animation:
    """A model in motion, made by `animate` or `turntable`: each frame is drawn when it is asked for.

    It has a length, and iteration gives the frames as Pillow images. In a notebook it shows itself in a player.
    """

    def __init__(
        self,
        models: Models,
        motion: Motion,
        size: Size,
        camera: CameraLike | None,
        background: ColorLike | None,
        device: Device | None,
        style: Style,
    ) -> None:
        self._models = models
        self._motion = motion
        self._size = parse_size(size)
        self._background = background
        self._device = device
        self._style = style
        poses.posed(models, np.eye(4), style)
        self._is_opaque = background is not None and rgba(background, "background")[3] == 1.0
        if isinstance(camera, Camera):
            self.camera = camera
        else:
            self._fit = fit_options(camera)
            Camera.fit(np.zeros((1, 3)), **self._fit)  # raises now, not at the first frame, as do the lines above

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self._size

    @property
    def fps(self) -> float:
        """Frames a second."""
        return self._motion.fps

    @cached_property
    def camera(self) -> Camera:
        """The camera of all frames."""
        aspect = self.size[0] / self.size[1]
        held = np.empty((0, 3))
        for k in range(len(self)):
            held = extreme_points(np.concatenate([held, self._outline(k)]), aspect, **self._fit)
        return Camera.fit(held, **self._fit)

    def _outline(self, k: int) -> Float64Array:
        """Return points of the world (n, 3) that a camera must hold in frame k."""
        layers = self._posed(k)
        with np.errstate(over="ignore", invalid="ignore"):
            points = framing_points(layers)
        require_in_range(points, f"frame {k}: the model")
        return points

    def frame(self, i: int) -> "Image":
        """Return frame `i` as a Pillow image, mode RGBA; from the end where `i` is negative."""
        i = as_int(i, "i")
        if not -len(self) <= i < len(self):
            raise ArgumentError.expecting("i", f"be a frame's number below {len(self)}", i)
        return images.image(self._begin(i % len(self)).result())

    def save(self, path: StrPath, *, progress: Progress | None = None) -> None:
        """Write the animation, holding few frames at a time; a file is there whole or not at all.

        path : its ending says how: .gif, .png or .apng (animated), .webp, .mp4, .webm, .html (a page with a player);
            or one file a frame, "frames/{frame:04}.png", whose folder is made where there is none
        progress : as `animate` takes it

        PNG, WebP and HTML are exact, and hold transparency. A GIF holds 255 colours without dithering, one palette for
        all frames but those that it does not suit, pixels either opaque or not, and at most 50 frames a second, timed
        in hundredths. MP4 and WebM are lossy and opaque, and need `pip install 'gpu_xform[video]'`; an MP4's odd sides
        gain a pixel (`SizeWarning`). All but those two play for ever.

        Raises `ArgumentError` for an unknown ending and for what the format cannot hold, `MissingExtraError` where
        PyAV is missing, and OSError from the operating system unchanged.
        """
        write = saver(path)
        with contextlib.ExitStack() as stack:
            if progress is None:
                progress = stack.enter_context(show_progress(os.fspath(path), " frames"))
            write(stack.enter_context(self._clip(progress)))

    def _repr_html_(self) -> str:
        page = io.BytesIO()
        with self._clip() as clip:
            html.write(page, clip)
        return html.embedded(page.getvalue().decode(), self.size)

    @contextlib.contextmanager
    def _clip(self, progress: Progress | None = None) -> Iterator[Clip]:
        """Lend what an encoder is given; where the block ends, nothing is being drawn any more."""
        sampled: dict[int, Pixels] = {}

        def drawn(numbers: Sequence[int]) -> Iterator[Pixels]:
            return stack.enter_context(contextlib.closing(self._drawn(numbers)))

        def samples(numbers: Sequence[int]) -> Iterator[Pixels]:
            for k, pixels in zip(numbers, drawn(numbers), strict=True):
                sampled[k] = pixels
                yield pixels

        def frames() -> Iterator[Pixels]:
            others = drawn([k for k in range(len(self)) if k not in sampled])
            for k in range(len(self)):
                yield sampled.pop(k) if k in sampled else next(others)
                if progress is not None:
                    progress(k + 1, len(self))

        with contextlib.ExitStack() as stack:
            yield Clip(self.size, len(self), self.fps, frames(), samples, self._is_opaque)

    def _drawn(self, numbers: Sequence[int]) -> Generator[Pixels]:
        """Draw frames by their numbers, each while the caller is busy with the one before it."""
        last = begun = None
        try:
            for k in numbers:
                last, begun = begun, self._begin(k, begun)
                if last is not None:
                    yield last.result()
            if begun is not None:
                yield begun.result()
        finally:
            for unread in (last, begun):
                if unread is not None:
                    unread.cancel()

    def _begin(self, k: int, overlap_with: PendingImage | None = None) -> PendingImage:
        frame = Frame(self.camera, self.size, self._background, self._device)
        return begin_render(self._posed(k), frame, {}, overlap_with=overlap_with)

    def _posed(self, k: int) -> list[Layer]:
        own = self._motion.at(k)
        with prefix_errors(f"frame {k}"):
            return poses.posed(self._models, own, self._style)

    def __len__(self) -> int:
        return self._motion.n_frames

    def __iter__(self) -> "Iterator[Image]":
        return map(self.frame, range(len(self)))

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Animation: {len(self)} frames of {width} x {height}, {self.fps:g} a second>"
