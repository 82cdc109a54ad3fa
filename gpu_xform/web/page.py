"""Pages: `save_page` writes models into one file that a browser draws live."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from string import Template
from typing import Unpack

import numpy as np

from .._core.arguments import as_int
from .._core.atomic_files import atomic_write
from .._core.error_context import prefix_errors
from .._core.public import public
from .._core.targets import find_target
from .._core.types import StrPath
from ..animation import Animation
from ..animation.motion import Motion, PosesLike, make_motion
from ..animation.poses import apply_pose
from ..annotation.options import NO_OPTIONS
from ..device import Device
from ..drawing.camera import Camera, CameraLike, fit_options
from ..drawing.intersections import add_intersections
from ..drawing.layer import Layer, Models, Style, as_layers, is_auto, require_style
from ..drawing.load_models import load_models, name_models
from ..drawing.prepare import Frame, Size, parse_size, prepare_frame
from ..drawing.sections import cut_sections
from ..drawing.style_signature import show_style_keywords
from ..drawing.thin import thin_layer
from ..errors import ArgumentError, ArgumentTypeError, SizeWarning
from ..geometry.edges import list_edge_parts
from ..geometry.mesh import Mesh
from ..imaging.colors import ColorLike, Rgba, parse_background
from ..imaging.image import Pixels
from ..rendering.raster import render_array
from .arrays import ArrayStore
from .decimation import decimate_layers
from .poster import encode_poster
from .program import read_text
from .scene import Frames, as_mesh_layer, describe_camera, describe_layers
from .short_program import encode_program, make_program, shorten_markup

DEFAULT_SIZE = (960, 720)
DEFAULT_TITLE = "gpu_xform"
MANY_EDGES = 1_000_000
STACK_LEVEL = 3


@public
@show_style_keywords
def save_page(
    models: Models | Animation,
    path: StrPath,
    frames: PosesLike | None = None,
    *,
    n_frames: int | None = None,
    duration: float | None = None,
    fps: float | None = None,
    title: str | None = None,
    camera: CameraLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    max_edges: int | None = None,
    **style: Unpack[Style],
) -> None:
    """Write a web page that draws models live: one file, which needs no network and no server.

    The page holds the models, and draws them with the package's own WGSL through WebGPU, so its pictures are those of
    `render`; a browser without WebGPU draws them on a 2D canvas. Drags rotate the models, and the keys are those of
    `view`. Where scripts do not run, the page shows a picture. A page has no texts: no labels, colour bar, axes or
    legend.

    Parameters
    ----------
    models : Mesh, (n, 3) numbers, PointBuffer, path, Layer, Scene, a list of these, or Animation
        The models, as `render` takes them; or an animation that moves them by matrices, as `turntable` makes one, with
        its own frames, style, camera, size, background and device: beside it, only `title` may be given.
    path : path
        The file, whose name ends in .html or .htm. It is written as a whole or not at all.
    frames : sequence, (k, 4, 4) numbers, or function, optional
        One item per frame of an animation, as `animate` takes them, of those that move the models by matrices: a matrix
        (4, 4), or a dict from names of a scene's nodes to their matrices. The page has a player then.
    n_frames, duration, fps : optional
        As `animate` takes them.
    title : str, optional
        The title of the page; by default the name of the model.
    camera : Camera or dict, optional
        The first view, as `render` takes it. By default the models fill windows of any shape.
    size : (width, height)
        The size in pixels of the picture that stands for the page where scripts do not run, and for which lines of
        the width "auto" are meant. The page itself is as large as its window.
    background : color or None
        The colour behind the models; None is transparent, and shows what is behind the page.
    device : Device, optional
        The device that draws the picture for browsers without scripts.
    max_edges : int, optional
        Hold at most about so many edges: points that lie close together become one. Without it, a page of more than a
        million edges is written as it is, and a `SizeWarning` says how large it is.
    **style
        Keywords of `Layer`, as `render` takes them, but for `labels` and `colorbar`. Positions are kept to a
        millionth of the extent of their model.

    Raises
    ------
    ArgumentError
        An argument has an impossible value, or a page cannot show it: "path must end in .html or .htm, got 'a.png'",
        "labels cannot go into a page".
    ArgumentTypeError
        An argument has a wrong type: "title must be a text, got int".
    MeshError
        A model has nothing to draw, or its file is malformed.
    OSError
        The operating system refuses to read a model or to write the file.
    """
    require_page_path(path)
    find_target(path)
    require_style(style)
    if title is not None and not isinstance(title, str):
        raise ArgumentTypeError.expecting("title", "be a text", type(title).__name__)
    if max_edges is not None and as_int(max_edges, "max_edges") < 1:
        raise ArgumentError.expecting("max_edges", "be at least 1", max_edges)
    given = {"frames": frames, "n_frames": n_frames, "duration": duration, "fps": fps, "camera": camera, **style}
    if isinstance(models, Animation):
        content = show_animation(models, [name for name, value in given.items() if value is not None])
    elif frames is not None:
        motion = make_motion(frames, fps, n_frames, duration)
        content = show_motion(models, motion, Frame(camera, parse_size(size), background, device), style)
    elif n_frames is None and duration is None and fps is None:
        content = show_models(models, Frame(camera, parse_size(size), background, device), style)
    else:
        raise ArgumentError("n_frames, duration and fps go with frames")
    data = encode_page(content, title, max_edges)
    with atomic_write(path) as file:
        file.write(data)


@dataclass(frozen=True)
class Content:
    """What a page shows.

    name : of the models, empty if they have none
    """

    layers: Sequence[Layer]
    frames: Frames
    frame: Frame
    name: str


def show_models(models: Models, frame: Frame, style: Style) -> Content:
    """Return models that do not move."""
    loaded = load_models(models)
    layers, frames = _stand(loaded, style)
    return Content(layers, frames, frame, name_models(models))


def show_motion(models: Models, motion: Motion, frame: Frame, style: Style) -> Content:
    """Return models that matrices move."""
    layers, frames = _follow(motion, load_models(models), style)
    return Content(layers, frames, frame, name_models(models))


def show_animation(animation: Animation, given: Sequence[str]) -> Content:
    """Return the models of an animation, which has what `given` names already."""
    if given:
        raise ArgumentError(f"{given[0]} cannot go with an Animation, which has its own", argument=given[0])
    recipe = animation.recipe
    if recipe.annotations != NO_OPTIONS:
        raise ArgumentError("axes and legend cannot go into a page, which has no texts", argument="axes")
    layers, frames = _follow(recipe.motion, recipe.models, recipe.style)
    frame = Frame(recipe.camera, recipe.size, recipe.background, recipe.device)
    return Content(layers, frames, frame, animation.title)


def encode_page(content: Content, title: str | None, max_edges: int | None) -> bytes:
    """Return the file that `save_page` writes; raises as that does for what cannot be drawn."""
    layers = content.layers if max_edges is None else decimate_layers(content.layers, max_edges)
    shown = title or content.name or layers[0].name or DEFAULT_TITLE
    background = parse_background(content.frame.background)
    page = _Page(shown, background, layers, content.frames, content.frame).encode()
    n_edges = sum(
        {id(layer.model): len(layer.model.edges) for layer in layers if isinstance(layer.model, Mesh)}.values()
    )
    if n_edges > MANY_EDGES and max_edges is None:
        size_mb = len(page) / 1e6
        message = (
            f"the page holds {n_edges:,} edges, and is {size_mb:.1f} MB large: max_edges (--max-edges) makes it smaller"
        )
        warnings.warn(message, SizeWarning, stacklevel=STACK_LEVEL)
    return page


def require_page_path(path: StrPath) -> None:
    """Raise `ArgumentError` for a path that does not end as a page does."""
    if not isinstance(path, str | os.PathLike):
        raise ArgumentTypeError.expecting("path", "be a path", type(path).__name__)
    if Path(os.fspath(path)).suffix.lower() not in (".html", ".htm"):
        raise ArgumentError.expecting("path", "end in .html or .htm", repr(str(path)))


def _stand(models: Models, style: Style) -> tuple[list[Layer], Frames]:
    """Return the layers of models that do not move, meshes in memory, and where they stand."""
    first = as_layers(models, style)
    _require_showable(first, is_moving=False)
    prepared = add_intersections(cut_sections([thin_layer(as_mesh_layer(layer)) for layer in first]))
    return prepared, Frames([layer.world_from_model[np.newaxis] for layer in prepared], 1.0)


def _follow(motion: Motion, models: Models, style: Style) -> tuple[list[Layer], Frames]:
    """Return the layers as they are at first, their models meshes in memory, and where they stand in each frame."""
    first: list[Layer] = []
    worlds = []
    for k in range(motion.n_frames):
        posed = apply_pose(models, motion.pose_at(k), style)
        if k == 0:
            first = posed
            _require_showable(first, is_moving=True)
        elif [id(layer.model) for layer in posed] != [id(layer.model) for layer in first]:
            raise ArgumentError.expecting(
                "frames", "move the models by matrices in a page", f"other models at frame {k}"
            )
        worlds.append([layer.world_from_model for layer in posed])
    layers = [thin_layer(as_mesh_layer(layer)) for layer in first]
    return layers, Frames([np.stack(stack) for stack in zip(*worlds, strict=True)], motion.fps)


def _require_showable(layers: Sequence[Layer], *, is_moving: bool) -> None:
    """Raise `ArgumentError` for styles that a page does not show."""
    for i, layer in enumerate(layers):
        with prefix_errors(layer.name or f"models[{i}]"):
            if layer.labels is not None:
                raise ArgumentError("labels cannot go into a page, which has no texts", argument="labels")
            if layer.colorbar is not False:
                raise ArgumentError("colorbar cannot go into a page, which has no texts", argument="colorbar")
            parts = [] if layer.edges is None else list_edge_parts(layer.edges)
            if is_moving and any(isinstance(part, str) and part == "intersection" for part in parts):
                raise ArgumentError("edges='intersection' cannot go into a page with frames", argument="edges")
            if is_moving and layer.section is not None:
                raise ArgumentError("section cannot go into a page with frames", argument="section")


@dataclass(frozen=True)
class _Page:
    """What a page is made of.

    background : straight alpha
    """

    title: str
    background: Rgba
    layers: Sequence[Layer]
    frames: Frames
    frame: Frame

    def encode(self) -> bytes:
        """Return the file."""
        picture, widths = self._draw()
        store = ArrayStore()
        described = describe_layers(self.layers, self.frames, widths, store)
        scene = {
            **described,
            "camera": self._describe_camera(store),
            "background": list(self.background),
        }
        fields = {
            "title": escape(self.title),
            "background": _css_color(self.background),
            "poster": encode_poster(picture),
            "program": encode_program(),
            "scene": store.encode(scene, make_program().names),
        }
        return Template(shorten_markup(read_text("page.html"))).substitute(fields).encode()

    def _draw(self) -> tuple[Pixels, list[float]]:
        """Return the picture of the first frame, and the width of the lines of each layer in it."""
        widths = [1.5 if is_auto(layer.line_width) else float(layer.line_width) for layer in self.layers]
        if any(is_auto(layer.line_width) for layer in self.layers):
            with prepare_frame(self.layers, self.frame, {}) as prepared:
                for i, drawable in zip(prepared.draw_list.layer_indices, prepared.draw_list.drawables, strict=True):
                    fitted = [lines.line_width for lines in drawable.lines if not lines.are_points]
                    if is_auto(self.layers[i].line_width) and fitted and fitted[-1]:
                        widths[i] = fitted[-1]
        frame = self.frame
        picture = render_array(
            self.layers, camera=frame.camera, size=frame.size, background=frame.background, device=frame.device
        )
        return picture, widths

    def _describe_camera(self, store: ArrayStore) -> dict[str, object]:
        width, height = self.frame.size
        camera = self.frame.camera
        if isinstance(camera, Camera):
            return describe_camera(camera, {}, self.layers, self.frames, width / height, store)
        return describe_camera(None, fit_options(camera), self.layers, self.frames, width / height, store)


def _css_color(color: Rgba) -> str:
    red, green, blue, alpha = color
    return f"rgb({255 * red:g} {255 * green:g} {255 * blue:g} / {alpha:g})"
