"""Animations of models: `animate` and `turntable` make them, `Animation` draws and saves their frames."""

from __future__ import annotations

import contextlib
import copy
import inspect
import io
import os
from collections.abc import Generator, Iterator, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack, overload

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_int, as_unit_vector, require_callable
from .._core.error_context import prefix_errors
from .._core.progress import show_progress
from .._core.public import public
from .._core.types import Float64Array, MatrixLike, Progress, StrPath
from ..annotation.axes import pad_bounds
from ..annotation.options import NO_OPTIONS, AnnotationOptions, AxesLike, LegendLike
from ..device import Device
from ..drawing.boxes import box_corners
from ..drawing.camera import (
    Camera,
    CameraLike,
    extreme_points,
    fit_options,
    front_direction,
    require_in_range,
    up_direction,
)
from ..drawing.framing import framing_points
from ..drawing.keys import check_legend, check_titles
from ..drawing.layer import Layer, Models, Style, require_style
from ..drawing.load_models import load_models, name_models
from ..drawing.prepare import Frame, Size, parse_size
from ..drawing.style_signature import show_keywords_of, show_style_keywords
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..imaging import image as images
from ..imaging.colors import ColorLike, to_rgba
from ..imaging.image import Pixels
from ..matrices import rotate, translate
from ..raster.base import PendingImage
from ..raster.choose import require_rasterizer
from ..raster.names import RasterizerName
from ..rendering.raster import begin_render
from .encoders import html
from .encoders.frames import FrameSequence
from .encoders.registry import make_writer
from .motion import Motion, PosesLike, choose_frames, make_motion, parse_frame_count
from .poses import apply_pose

if TYPE_CHECKING:
    from PIL.Image import Image

DEFAULT_SIZE = (640, 480)
MIN_UPRIGHT_COSINE = 0.999  # between the axis of a turntable and the up direction


@public
@show_style_keywords
def animate(
    models: Models,
    frames: PosesLike,
    path: StrPath | None = None,
    *,
    n_frames: int | None = None,
    duration: float | None = None,
    fps: float | None = None,
    size: Size = DEFAULT_SIZE,
    camera: CameraLike | None = None,
    background: ColorLike | None = "white",
    device: Device | None = None,
    rasterizer: RasterizerName = "auto",
    progress: Progress | None = None,
    axes: AxesLike = False,
    legend: LegendLike = False,
    font: StrPath | None = None,
    font_size: float | None = None,
    **style: Unpack[Style],
) -> Animation:
    """Return an animation of models; nothing is drawn until a frame or a file is requested.

    Parameters
    ----------
    models : Mesh, (n, 3) numbers, path, PointBuffer, Springs, Layer, Scene, or a list of these
        The models, as `render` takes them.
    frames : sequence, (k, 4, 4) numbers, Trajectory, or function
        One item per frame: a matrix (4, 4) that moves the models; or a dict from names of a scene's nodes to their
        matrices; or another model in place of the first of the models, in its style, an array of points as
        `Mesh(points)`; or a Scene in place of all models. A stack of matrices, or of SciPy's rotations, is such a
        sequence, and so is a `Trajectory`. A function returns the item of a frame; it may be called several times for
        one frame, and must return the same each time.
    path : path, optional
        The file in which the animation is saved at once, as by `Animation.save`. By default it is not saved.
    n_frames : int, optional
        The number of frames, if `frames` is a function of the frame's index, from 0.
    duration : float, optional
        The duration in seconds, if `frames` is a function of the frame's time in seconds. Excludes `n_frames`.
    fps : float, optional
        Frames per second, from 0.01 to 1000; by default those of a `Trajectory`, else 20.
    size : (width, height)
        The size of the frames in pixels.
    camera : Camera or dict, optional
        The camera of all frames. The default is one `Camera.fit` that holds the models in every frame; a dict of its
        keywords, such as {"direction": (0, 0, -1)}, changes how it fits.
    background : color or None
        The colour behind the models; None is transparent.
    device : Device, optional
        The device that draws; by default the device of the first `PointBuffer`, or else the process's own.
    rasterizer : "auto", "render" or "compute"
        How edges become pixels, as `render` takes it.
    progress : function, optional
        Called with the number of frames drawn and the number of all frames while the file is written. By default a
        progress bar appears after a second, on a terminal only.
    axes, legend : optional
        Axes and a legend, as `render` takes them. The axes are around the models of all frames, and stand still.
    font, font_size : optional
        The font and the size of texts, as `render` takes them.
    **style
        Keywords of `Layer`, as `render` takes them. The matrix of a frame applies after `transform`.

    Returns
    -------
    Animation
        A sequence of frames that is drawn when needed.

    Raises
    ------
    ArgumentError
        An argument has an impossible value, or a frame cannot be drawn: "frames must hold at least one, got none",
        "frames raised at frame 2: IndexError: list index out of range".
    ArgumentTypeError
        An argument has a wrong type: "path must be a path, got int".
    MeshError
        A model has nothing to draw, or its file is malformed.
    MissingExtraError, OSError
        As `Animation.save` raises them, if a path is given.
    """
    require_style(style, inspect.signature(animate).parameters)
    motion = make_motion(frames, fps, n_frames, duration)
    annotations = AnnotationOptions(axes, legend, font, font_size)
    loaded, title = load_models(models), name_models(models)
    animation = Animation(loaded, motion, size, camera, background, device, rasterizer, style, annotations, title)
    if path is not None:
        animation.save(path, progress=progress)
    return animation


@public
@show_keywords_of(animate, but="n_frames")
def turntable(
    models: Models,
    frames: int = 100,
    path: StrPath | None = None,
    *,
    axis: npt.ArrayLike | None = None,
    transform: MatrixLike | None = None,
    **options: Any,
) -> Animation:
    """Return an animation of models that rotate once about an axis through the centre of their bounds.

    About the up direction they are seen from the front first, and somewhat from above, unless `camera` has a direction:
    four frames are the front, a side, the back and the other side, eight frames also the corners between them.

    Parameters
    ----------
    models : Mesh, (n, 3) numbers, path, PointBuffer, Layer, Scene, or a list of these
        The models, as `animate` takes them.
    frames : int
        The number of frames. The last is one step before the first, so that a loop has no stop.
    path : path, optional
        The file in which the animation is saved at once, as by `Animation.save`. By default it is not saved.
    axis : (3,) numbers or an axis such as "z" or "-Y", optional
        The axis, by default the up direction of `camera`, which is +y unless it says otherwise. The rotation is
        counter-clockwise, seen from the end of the axis.
    transform : (4, 4) or (k, 4, 4) numbers, optional
        Applied to the models, of which there are k instances, before they rotate.
    **options
        Further keywords of `animate`, such as fps, size, camera, progress, or those of a style.

    Returns
    -------
    Animation
        A sequence of frames that is drawn when needed.

    Raises
    ------
    MeshError
        The models have no points.
    ArgumentError
        An argument has an impossible value: "axis must not be the zero vector"; otherwise as `animate`.
    """
    own, known = (inspect.signature(function).parameters for function in (turntable, animate))
    require_style(options.keys() - known.keys(), [*own, *known])
    if "n_frames" in options:
        raise ArgumentTypeError("n_frames: turntable takes the number of its frames as frames", argument="n_frames")
    n_frames = parse_frame_count(frames, "frames")
    unit_axis = up_direction(options.get("camera")) if axis is None else as_unit_vector(axis, "axis", 3)
    loaded = load_models(models)
    placement: Style = {} if transform is None else {"transform": transform}
    points = framing_points(apply_pose(loaded, np.eye(4), placement))
    if len(points) == 0:
        raise MeshError("a model without points cannot turn about its centre")
    centre = 0.5 * points.min(axis=0) + 0.5 * points.max(axis=0)
    to_centre, from_centre = translate(*-centre), translate(*centre)
    camera = options.get("camera")
    if not isinstance(camera, Camera):
        fit, up = fit_options(camera), up_direction(camera)
        if fit.get("direction") is None and abs(up @ unit_axis) > MIN_UPRIGHT_COSINE:
            options["camera"] = fit | {"direction": front_direction(up)}

    rotation = partial(_rotate_about, unit_axis, from_centre, to_centre, n_frames)
    progress = options.pop("progress", None)
    animation = animate(loaded, rotation, n_frames=n_frames, **placement, **options)
    animation.title = name_models(models)
    if path is not None:
        animation.save(path, progress=progress)
    return animation


def _rotate_about(
    axis: Float64Array, from_centre: Float64Array, to_centre: Float64Array, n_frames: int, k: int
) -> Float64Array:
    """Return the pose of a frame of `turntable`; no function inside it, which could not be pickled."""
    return from_centre @ rotate(axis, 360.0 * k / n_frames, degrees=True) @ to_centre


class AnimationRecipe(NamedTuple):
    """Models, their motion and their style, and the view of them; a camera may be keywords of `Camera.fit`."""

    models: Models
    motion: Motion
    style: Style
    camera: CameraLike
    size: tuple[int, int]
    background: ColorLike | None
    device: Device | None
    annotations: AnnotationOptions


@public
class Animation:
    """A sequence of frames of moving models, made by `animate` or `turntable`; each is drawn when it is requested.

    `len` gives the number of frames. `animation[3]` and iteration draw frames as Pillow images; `animation[10:20]` is
    an animation of these frames, seen by the same camera. In a notebook an animation shows itself in a player.
    """

    def __init__(
        self,
        models: Models,
        motion: Motion,
        size: Size,
        camera: CameraLike | None,
        background: ColorLike | None,
        device: Device | None,
        rasterizer: RasterizerName,
        style: Style,
        annotations: AnnotationOptions = NO_OPTIONS,
        title: str = "",
    ) -> None:
        self.title = title  # of pages; empty for models without a name
        self._models = models
        self._motion = motion
        self._size = parse_size(size)
        self._background = background
        self._device = device
        self._rasterizer = rasterizer
        self._style = style
        self._annotations = annotations
        require_rasterizer(rasterizer)
        apply_pose(models, np.eye(4), style)
        check_titles(annotations.axes)
        check_legend(annotations.legend)
        self._is_opaque = background is not None and to_rgba(background, "background")[3] == 1.0
        if isinstance(camera, Camera):
            self.camera = camera
        else:
            self._fit = fit_options(camera)
            Camera.fit(np.zeros((1, 3)), **self._fit)  # raises now, not at the first frame, as do the lines above

    @property
    def size(self) -> tuple[int, int]:
        """The size of the frames: (width, height) in pixels."""
        return self._size

    @property
    def recipe(self) -> AnimationRecipe:
        """What the frames are made of, for what draws them in another way than as pictures.

        Returns
        -------
        AnimationRecipe
        """
        camera = self.__dict__.get("camera") or self._fit
        return AnimationRecipe(
            self._models,
            self._motion,
            self._style,
            camera,
            self.size,
            self._background,
            self._device,
            self._annotations,
        )

    @property
    def fps(self) -> float:
        """The number of frames per second."""
        return self._motion.fps

    @cached_property
    def camera(self) -> Camera:
        """The camera of all frames: the one that was given, or one that holds the models in every frame."""
        aspect = self.size[0] / self.size[1]
        extreme = np.empty((0, 3))
        for k in range(len(self)):
            extreme = extreme_points(np.concatenate([extreme, self._framing_points(k)]), aspect, **self._fit)
        if self._axes_bounds is not None:
            extreme = np.concatenate([extreme, box_corners(pad_bounds(self._axes_bounds))])
        return Camera.fit(extreme, **self._fit)

    @cached_property
    def _axes_bounds(self) -> Float64Array | None:
        """The bounds (2, 3) of the models in all frames; None without axes."""
        if self._annotations.axes is False:
            return None
        extremes = [self._framing_points(k) for k in range(len(self))]
        found = [np.stack([points.min(axis=0), points.max(axis=0)]) for points in extremes if len(points)]
        if not found:
            raise MeshError("models must have finite points with w > 0 to have axes around them")
        corners = np.concatenate(found)
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def frame(self, i: int) -> Image:
        """Draw one frame.

        Parameters
        ----------
        i : int
            The index of the frame, from 0; a negative index counts from the end.

        Returns
        -------
        PIL.Image.Image
            The picture, mode RGBA.

        Raises
        ------
        ArgumentError
            There is no such frame, "i must be a frame's number below 5, got 7", or the models cannot be drawn in it.
        """
        i = as_int(i, "i")
        if not -len(self) <= i < len(self):
            raise ArgumentError.expecting("i", f"be a frame's number below {len(self)}", i)
        return images.to_pillow(self._begin(i % len(self)).result())

    def save(self, path: StrPath, *, progress: Progress | None = None) -> None:
        """Write the animation to a file, or to one file per frame; few frames are in memory at a time.

        PNG, WebP and HTML are lossless, and hold transparency; a notebook, which shows the same player, gets lossy
        frames where lossless ones take more than a megabyte. A GIF holds 255 colours without dithering, one palette for
        all frames except those that it does not suit, pixels that are either opaque or transparent, and at most 50
        frames per second, timed in hundredths of a second. PNG and WebP hold at most 90 frames per second, because
        browsers show faster ones ten times as slowly. MP4 and WebM are lossy and opaque, and need
        `pip install 'gpu_xform[video]'`; odd sides of an MP4 are padded by a pixel (`SizeWarning`). All formats except
        these two loop for ever. A file is written as a whole or not at all.

        Parameters
        ----------
        path : path
            The file. Its ending names the format: .gif, .png or .apng (animated), .webp, .mp4, .webm, or .html (a page
            with a player). "frames/{frame:04}.png" is one file per frame; its folder is created if it does not exist.
        progress : function, optional
            Called with the number of frames drawn and the number of all frames. By default a progress bar appears after
            a second, on a terminal only.

        Raises
        ------
        ArgumentError
            The ending is unknown, or the format cannot hold the size, the rate or the background: "size must be at most
            16383 x 16383 in a WebP, got 20000 x 10".
        MissingExtraError
            The format is MP4 or WebM, and PyAV is not installed.
        OSError
            The operating system refuses to write the file.
        """
        require_callable(progress, "progress")
        write = make_writer(path)
        with contextlib.ExitStack() as stack:
            if progress is None:
                progress = stack.enter_context(show_progress(os.fspath(path), " frames"))
            write(stack.enter_context(self._frame_sequence(progress)))

    def _repr_html_(self) -> str:
        page = io.BytesIO()
        with self._frame_sequence() as sequence:
            html.write(page, sequence, max_bytes=html.MAX_CELL_BYTES)
        return html.embed_page(page.getvalue().decode(), self.size)

    @contextlib.contextmanager
    def _frame_sequence(self, progress: Progress | None = None) -> Iterator[FrameSequence]:
        """Lend the frames to an encoder; after the block nothing is being drawn any more."""
        sampled: dict[int, Pixels] = {}

        def draw(indices: Sequence[int]) -> Iterator[Pixels]:
            return stack.enter_context(contextlib.closing(self._draw(indices)))

        def sample(indices: Sequence[int]) -> Iterator[Pixels]:
            for k, pixels in zip(indices, draw(indices), strict=True):
                sampled[k] = pixels
                yield pixels

        def frames() -> Iterator[Pixels]:
            others = draw([k for k in range(len(self)) if k not in sampled])
            for k in range(len(self)):
                yield sampled.pop(k) if k in sampled else next(others)
                if progress is not None:
                    progress(k + 1, len(self))

        with contextlib.ExitStack() as stack:
            yield FrameSequence(self.size, len(self), self.fps, frames(), sample, self._is_opaque, self.title)

    def _draw(self, indices: Sequence[int]) -> Generator[Pixels]:
        """Yield frames by their indices; each is drawn while the caller works on the one before it."""
        last = begun = None
        try:
            for k in indices:
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
        frame = Frame(
            self.camera, self.size, self._background, self._device, self._annotations, axes_bounds=self._axes_bounds
        )
        layers = self._layers(k)
        return begin_render(layers, frame, {}, rasterizer=self._rasterizer, overlap_with=overlap_with)

    def _framing_points(self, k: int) -> Float64Array:
        """Return points of the world (n, 3) that a camera must hold in frame k."""
        layers = self._layers(k)
        with np.errstate(over="ignore", invalid="ignore"):
            points = framing_points(layers)
        require_in_range(points, f"frame {k}: the model")
        return points

    def _layers(self, k: int) -> list[Layer]:
        pose = self._motion.pose_at(k)
        with prefix_errors(f"frame {k}"):
            return apply_pose(self._models, pose, self._style)

    def __len__(self) -> int:
        return self._motion.n_frames

    @overload
    def __getitem__(self, frames: int) -> Image: ...
    @overload
    def __getitem__(self, frames: slice) -> Animation: ...
    def __getitem__(self, frames: int | slice) -> Image | Animation:
        if not isinstance(frames, slice):
            i = as_int(frames, "frames")
            if not -len(self) <= i < len(self):
                raise IndexError(f"frame {i} of {len(self)}")
            return self.frame(i)
        chosen = range(len(self))[frames]
        if not chosen:
            raise ArgumentError.expecting("frames", f"choose some of {len(self)} frames", repr(frames))
        part = copy.copy(self)
        part.camera = self.camera  # cached properties, found over all frames
        part._axes_bounds = self._axes_bounds
        part._motion = choose_frames(self._motion, chosen)
        return part

    def __iter__(self) -> Iterator[Image]:
        return map(self.frame, range(len(self)))

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Animation: {len(self)} frames of {width} x {height}, {self.fps:g} a second>"
