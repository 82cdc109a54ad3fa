"""Viewing session: models in memory, the view of them, and the pictures that any window shows."""

import io
import os
import re
import time
from collections.abc import Callable
from functools import cached_property
from itertools import count
from pathlib import Path

import numpy as np

from .._core.atomic_files import atomic_write
from .._core.types import Float64Array
from ..annotation.options import NO_OPTIONS, AnnotationOptions, scale_font
from ..device import Device
from ..drawing.axes_layout import box_of_axes
from ..drawing.boxes import box_corners
from ..drawing.camera import Camera, CameraLike, fit_options
from ..drawing.framing import framing_points
from ..drawing.layer import Models, Style, as_layers, at_present
from ..drawing.load_models import PATH_TYPES, load_models
from ..errors import ArgumentError, MeshError
from ..imaging import image as images
from ..imaging.colors import ColorLike, parse_background
from ..imaging.image import Pixels
from ..raster.names import RasterizerName
from ..rendering.raster import render_array
from ..simulation.conditions import ConditionOptions
from .controls import Controls, Event, InitialView, Request
from .help_overlay import draw_help
from .live_springs import LiveSprings
from .orbit import BoundingSphere
from .style_overrides import apply_overrides, has_faces, list_edge_sets

DRAWING_ERRORS = (MeshError, ArgumentError)


class Session:
    """Models in memory, the view that events have made of them, and its pictures.

    The arguments are those of `view`. Raises as `render` does.
    """

    def __init__(
        self,
        models: Models,
        camera: CameraLike | None,
        up: Float64Array | None,
        size: tuple[int, int],
        background: ColorLike | None,
        device: Device | None,
        rasterizer: RasterizerName,
        style: Style,
        conditions: ConditionOptions | None = None,
        annotations: AnnotationOptions = NO_OPTIONS,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._layers = as_layers(load_models(models, is_live=True), style)
        self._live = LiveSprings(self._layers, conditions or {}, clock)
        if conditions is not None and not self._live.is_there:
            raise ArgumentError("conditions say what acts on springs, and there are none", argument="conditions")
        self._name = Path(models).stem if isinstance(models, PATH_TYPES) else self._layers[0].name or "gpu-xform"
        self._background = background
        self._device = device
        self._rasterizer = rasterizer
        self._annotations = annotations
        self._size, self._pixel_ratio = size, 1.0
        if not isinstance(camera, Camera):
            camera = ({} if up is None else {"up": up}) | fit_options(camera)
        # What cannot be drawn raises here, before there is a window.
        render_array(
            self._layers,
            camera=camera,
            size=size,
            background=background,
            device=device,
            rasterizer=rasterizer,
            **vars(annotations),
        )
        points = framing_points(self._layers)
        if not isinstance(camera, Camera):
            beside = [] if annotations.axes is False else [box_corners(box_of_axes(points))]
            camera = Camera.fit(np.concatenate([points, *beside]), **camera)
        present = [at_present(layer) for layer in self._layers]
        first = next((layer for layer in present if has_faces(layer)), present[0])
        self._camera = camera
        self._controls = Controls(
            InitialView(
                camera,
                BoundingSphere.around(points),
                lambda: framing_points(self._layers),
                first,
                background,
                up,
                lambda: self._edge_sets,
            )
        )
        self._saved = self._problem = ""
        self.is_closed = False

    @property
    def name(self) -> str:
        """What the models are called together."""
        others = len(self._layers) - 1
        return f"{self._name} and {others} more" if others else self._name

    @property
    def title(self) -> str:
        """The title of the window: the models, and what the last event did."""
        note = self._saved or self._problem or self._controls.view.note or "H shows the keys"
        return f"{self.name} - {', '.join(filter(None, [self._live.note, note]))}"

    @property
    def is_moving(self) -> bool:
        """Whether the picture changes without an event."""
        return self._live.is_running

    def handle(self, event: Event, size: tuple[float, float]) -> bool:
        """Apply an event of rendercanvas, in a window of `size` in its units; return whether the picture changes."""
        before = self._controls.view
        if self._live.handle(event, size, self._camera if before.orbit is None else before.orbit.camera):
            return True
        request = self._controls.handle(event, size)
        has_changed = self._controls.view is not before
        if request is Request.SAVE:
            self._saved = self._save()
        elif has_changed:
            self._saved = ""
        self.is_closed = self.is_closed or request is Request.CLOSE
        return has_changed

    def draw(self, size: tuple[int, int], pixel_ratio: float) -> Pixels:
        """Return what a window of `size` pixels shows: an opaque picture, transparent parts on white."""
        self._size, self._pixel_ratio = size, pixel_ratio
        self._live.advance()
        picture = self._render()
        if (picture[..., 3] < 255).any():
            white = 255 - picture[..., 3:]
            picture = images.premultiply(picture) + white
        if self._controls.view.has_help:
            picture = draw_help(picture, pixel_ratio, has_simulation=self._live.is_there)
        return picture

    def close(self) -> None:
        """Let go of what the pointer holds."""
        self._live.let_go()

    @cached_property
    def _edge_sets(self) -> list[tuple[str, ...]]:
        """The sets of edges that each layer has, found when they are first asked for."""
        return [list_edge_sets(at_present(layer)) for layer in self._layers]

    def _render(self) -> Pixels:
        """Return the picture; only the background if what is requested has nothing to draw."""
        view = self._controls.view
        edge_sets = None if view.overrides.edges is None else self._edge_sets
        background = self._background if view.overrides.background is None else view.overrides.background
        self._problem = ""
        try:
            return render_array(
                apply_overrides(
                    [at_present(layer) for layer in self._layers], view.overrides, self._pixel_ratio, edge_sets
                ),
                camera=self._camera if view.orbit is None else view.orbit.camera,
                size=self._size,
                background=background,
                device=self._device,
                rasterizer=self._rasterizer,
                **vars(scale_font(self._annotations, self._pixel_ratio)),
            )
        except DRAWING_ERRORS as error:
            self._problem = str(error)
            color = parse_background(background)
            width, height = self._size
            return np.broadcast_to(np.rint(np.multiply(color, 255)).astype(np.uint8), (height, width, 4))

    def _save(self) -> str:
        """Save the picture under a file name that does not exist yet; return a note on it."""
        stem = re.sub(r"[^\w.-]+", "_", self._name)
        png = io.BytesIO()  # because Pillow reports every failure to write as an encoder's error
        images.to_pillow(self._render()).save(png, "PNG")
        try:
            path = next(path for number in count(1) if not os.path.lexists(path := f"{stem}-{number}.png"))
            with atomic_write(path) as file:
                file.write(png.getvalue())
        except OSError as error:
            return f"not saved: {error.strerror or error}"
        return f"saved {path}"
