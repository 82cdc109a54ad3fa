"""Models and the view of them: what a window shows, whichever window it is."""

import io
import os
import re
from itertools import count
from pathlib import Path

import numpy as np

from .._core.atomic_files import atomic_write
from .._core.types import Float64Array
from ..drawing.camera import Camera, CameraLike, fit_options
from ..drawing.framing import framing_points
from ..drawing.layer import Models, Style, as_layers
from ..drawing.load_models import PATH_TYPES, load_models
from ..errors import ArgumentError, MeshError
from ..gpu.device import Device
from ..imaging import image as images
from ..imaging.colors import ColorLike, backdrop
from ..imaging.image import Pixels
from ..rendering.raster import render_array
from .controls import Controls, Event, Given, Request
from .help_overlay import with_help
from .orbit import Ball
from .style_overrides import has_faces, restyled

NOTHING_DRAWN = (MeshError, ArgumentError)


class Session:
    """Models in memory, what events have made of their view, and the pictures of it.

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
        style: Style,
    ) -> None:
        self._layers = as_layers(load_models(models), style)
        self._name = Path(models).stem if isinstance(models, PATH_TYPES) else self._layers[0].name or "gpu-xform"
        self._background = background
        self._device = device
        self._size, self._pixel_ratio = size, 1.0
        if not isinstance(camera, Camera):
            camera = ({} if up is None else {"up": up}) | fit_options(camera)
        # Whatever cannot be drawn is said here, before there is a window.
        render_array(self._layers, camera=camera, size=size, background=background, device=device)
        points = framing_points(self._layers)
        if not isinstance(camera, Camera):
            camera = Camera.fit(points, **camera)
        first = next((layer for layer in self._layers if has_faces(layer)), self._layers[0])
        self._camera = camera
        self._controls = Controls(
            Given(camera, Ball.around(points), lambda: framing_points(self._layers), first, background, up)
        )
        self._saved = self._problem = ""
        self.is_closed = False

    @property
    def title(self) -> str:
        """What stands above the window."""
        others = len(self._layers) - 1
        name = f"{self._name} and {others} more" if others else self._name
        return f"{name} - {self._saved or self._problem or self._controls.view.note or 'H shows the keys'}"

    def handle(self, event: Event, size: tuple[float, float]) -> bool:
        """Take an event of rendercanvas, in a window of `size` in its units; return whether the picture is another."""
        before = self._controls.view
        request = self._controls.handle(event, size)
        is_other = self._controls.view is not before
        if request is Request.SAVE:
            self._saved = self._save()
        elif is_other:
            self._saved = ""
        self.is_closed = self.is_closed or request is Request.CLOSE
        return is_other

    def shown(self, size: tuple[int, int], pixel_ratio: float) -> Pixels:
        """Return what a window of `size` pixels shows, opaque: what is transparent is shown on white."""
        self._size, self._pixel_ratio = size, pixel_ratio
        picture = self._drawn()
        if (picture[..., 3] < 255).any():
            white = 255 - picture[..., 3:]
            picture = images.premultiplied(picture) + white
        return with_help(picture, pixel_ratio) if self._controls.view.has_help else picture

    def _drawn(self) -> Pixels:
        """Return the picture; where what is asked for has nothing to draw, its background."""
        view = self._controls.view
        background = self._background if view.look.ground is None else view.look.ground
        self._problem = ""
        try:
            return render_array(
                restyled(self._layers, view.look, self._pixel_ratio),
                camera=self._camera if view.orbit is None else view.orbit.camera,
                size=self._size,
                background=background,
                device=self._device,
            )
        except NOTHING_DRAWN as error:
            self._problem = str(error)
            ground = backdrop(background)
            width, height = self._size
            return np.broadcast_to(np.rint(np.multiply(ground, 255)).astype(np.uint8), (height, width, 4))

    def _save(self) -> str:
        """Write what is seen beside what is there already; return what to say of it."""
        stem = re.sub(r"[^\w.-]+", "_", self._name)
        png = io.BytesIO()  # because Pillow calls every failure to write an encoder's error
        images.image(self._drawn()).save(png, "PNG")
        try:
            path = next(path for number in count(1) if not os.path.lexists(path := f"{stem}-{number}.png"))
            with atomic_write(path) as file:
                file.write(png.getvalue())
        except OSError as error:
            return f"not saved: {error.strerror or error}"
        return f"saved {path}"
