"""Contact sheets: small pictures of many models on one sheet, each over its name."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..annotation.items import Annotation, Line, Rectangle, Shape, Text
from ..annotation.options import AnnotationOptions
from ..annotation.paint import draw_annotation
from ..annotation.text_style import TextStyle, make_text_style, move_text
from ..drawing.layer import Layer
from ..drawing.prepare import Frame
from ..errors import ArgumentError
from ..imaging.colors import ColorLike, Rgba, parse_background
from ..imaging.image import to_pillow
from ..vector import VectorLayer, format_pdf, format_svg
from .raster import render_array
from .vector import draw_layers

TILE_PX = 256  # the longer side of each picture
GAP_PX = 16  # around and between the pictures
MAX_SIDE_PX = 8192  # of a sheet, whose pictures become smaller if there are too many
MIN_TILE_PX = 24
FONT_SHARE = 0.055  # of the longer side of a picture
FAILED_COLOR: Rgba = (0.76, 0.17, 0.17, 1.0)
FRAME_ALPHA = 0.2
ELLIPSIS = "\N{HORIZONTAL ELLIPSIS}"


@dataclass(frozen=True)
class _Grid:
    """Where pictures of `tile` pixels (width, height) lie, row by row."""

    n_columns: int
    n_rows: int
    tile: tuple[int, int]
    caption_height: int

    @property
    def size(self) -> tuple[int, int]:
        """The size of the sheet."""
        width, height = self.tile
        return (
            GAP_PX + self.n_columns * (width + GAP_PX),
            GAP_PX + self.n_rows * (height + self.caption_height + GAP_PX),
        )

    def origin(self, i: int) -> tuple[int, int]:
        """Return the upper left corner of picture i."""
        row, column = divmod(i, self.n_columns)
        return (
            GAP_PX + column * (self.tile[0] + GAP_PX),
            GAP_PX + row * (self.tile[1] + self.caption_height + GAP_PX),
        )


class ContactSheet:
    """A sheet that pictures are added to one by one.

    names : the texts under the pictures, one per picture
    aspect : (width, height) of the pictures, in any unit
    file_type : "png", "svg" or "pdf"
    """

    def __init__(
        self,
        names: Sequence[str],
        aspect: tuple[int, int],
        file_type: str,
        *,
        background: ColorLike | None,
        font: Any = None,
    ) -> None:
        self._names = names
        self._file_type = file_type
        self._grid = _fit_grid(len(names), aspect)
        self._background = background
        red, green, blue, alpha = parse_background(background)
        font_size = max(1.0, round(FONT_SHARE * max(self.tile)))
        self._style = make_text_style(font, font_size, self.tile, (red, green, blue, alpha))
        width, height = self._grid.size
        if file_type == "png":
            self._pixels = np.empty((height, width, 4), np.uint8)
            self._pixels[:] = np.floor(255.0 * np.array([red, green, blue, alpha]) + 0.5)
        self._layers: list[VectorLayer] = []
        self._annotation = Annotation()
        self._missing = set(range(len(names)))

    @property
    def tile(self) -> tuple[int, int]:
        """The size of each picture in pixels."""
        return self._grid.tile

    def add(self, i: int, layers: Sequence[Layer], arguments: dict[str, Any], **raster: Any) -> None:
        """Draw picture i with the keywords that all renderers share, and those of pixels. Raises as `render` does."""
        x, y = self._grid.origin(i)
        arguments = arguments | {"size": self.tile}
        if self._file_type == "png":
            pixels = render_array(layers, **arguments, **raster)
            self._pixels[y : y + self.tile[1], x : x + self.tile[0]] = pixels
        else:
            self._add_vectors(layers, arguments, x, y)
        self._missing.discard(i)

    def finish(self) -> Any:
        """Return the sheet: a Pillow image, the text of an SVG, or the bytes of a PDF."""
        annotation = self._annotation + self._annotate()
        if self._file_type == "png":
            draw_annotation(self._pixels, annotation)
            return to_pillow(self._pixels)
        write = {"svg": format_svg, "pdf": format_pdf}[self._file_type]
        return write(self._grid.size, parse_background(self._background), self._layers, annotation)

    def _add_vectors(self, layers: Sequence[Layer], arguments: dict[str, Any], x: int, y: int) -> None:
        names = ("camera", "size", "background", "device")
        options = AnnotationOptions(*(arguments[name] for name in ("axes", "legend", "font", "font_size")))
        frame = Frame(**{name: arguments[name] for name in names}, annotations=options)
        views, projection = arguments.get("views"), arguments.get("projection", "third")
        _, _, drawn, annotation = draw_layers(layers, frame, {}, views, projection)
        self._layers += [layer.moved(x, y) for layer in drawn]
        self._annotation += _move_annotation(annotation, x, y)

    def _annotate(self) -> Annotation:
        """Return the names, the frames, and a word in place of each picture that is missing."""
        width, height = self.tile
        shapes: list[Shape] = []
        texts = []
        red, green, blue, _ = self._style.color
        for i, name in enumerate(self._names):
            x, y = self._grid.origin(i)
            corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
            for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
                shapes.append(Line(x0, y0, x1, y1, 1.0, (red, green, blue, FRAME_ALPHA)))
            color = FAILED_COLOR if i in self._missing else None
            texts.append(_center(_fit_text(self._style, name, width, color), x + width / 2, y + height, below=True))
            if i in self._missing:
                text = _fit_text(self._style, "not drawn", width, FAILED_COLOR)
                texts.append(_center(text, x + width / 2, y + height / 2, below=False))
        return Annotation(shapes, texts)


def _fit_grid(n: int, aspect: tuple[int, int]) -> _Grid:
    """Return a grid for n pictures that is about as wide as it is high, with the largest pictures that it holds."""
    side = TILE_PX
    while True:
        width, height = (max(1, round(side * length / max(aspect))) for length in aspect)
        caption = math.ceil(2.0 * FONT_SHARE * side)
        n_columns = max(1, min(n, round(math.sqrt(n * (height + caption + GAP_PX) / (width + GAP_PX)) + 0.3)))
        grid = _Grid(n_columns, -(-n // n_columns), (width, height), caption)
        if max(grid.size) <= MAX_SIDE_PX or side <= MIN_TILE_PX:
            return grid
        side -= 4


def _fit_text(style: TextStyle, name: str, width: float, color: Rgba | None) -> Text:
    """Return a name, without its middle if it would be wider than `width`; escapes stand for what no font has."""
    try:
        text = style.text(name, "names", color=color)
    except ArgumentError:
        name = name.encode("ascii", "backslashreplace").decode()
        text = style.text(name, "names", color=color)
    n_kept = len(name)
    while text.width > width and n_kept > 2:
        n_kept = min(n_kept - 1, int(n_kept * width / text.width) + 1)
        tail = n_kept // 2
        text = style.text(f"{name[: n_kept - tail]}{ELLIPSIS}{name[len(name) - tail :]}", "names", color=color)
    return text


def _center(text: Text, x: float, y: float, *, below: bool) -> Text:
    """Return the text with its middle over or under (x, y)."""
    height = text.box.bottom - text.box.top
    return move_text(text, x - text.width / 2, y + 0.25 * height if below else y - 0.5 * height)


def _move_annotation(annotation: Annotation, x: float, y: float) -> Annotation:
    texts = [move_text(text, text.box.left + x, text.box.top + y) for text in annotation.texts]
    return Annotation([_move_shape(shape, x, y) for shape in annotation.shapes], texts)


def _move_shape(shape: Shape, x: float, y: float) -> Shape:
    if isinstance(shape, Line):
        return replace(shape, x0=shape.x0 + x, y0=shape.y0 + y, x1=shape.x1 + x, y1=shape.y1 + y)
    if isinstance(shape, Rectangle):
        return replace(shape, box=shape.box.moved(x, y))
    return replace(shape, x=shape.x + x, y=shape.y + y)
