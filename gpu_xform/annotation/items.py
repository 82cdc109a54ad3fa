"""Items: what an annotation is made of. Every back end draws these, in pixels from the top left corner, y down."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ..imaging.colors import Rgba
from .fonts import Font


class Box(NamedTuple):
    """An upright rectangle."""

    left: float
    top: float
    right: float
    bottom: float

    def moved(self, x: float, y: float) -> "Box":
        """Return the box, moved."""
        return Box(self.left + x, self.top + y, self.right + x, self.bottom + y)

    def widened(self, margin: float) -> "Box":
        """Return the box with a margin on each side."""
        return Box(self.left - margin, self.top - margin, self.right + margin, self.bottom + margin)


@dataclass(frozen=True)
class Text:
    """A line of text, in one font and one colour, with a halo around its letters.

    x, y : the left end of the baseline
    width : the advance of the text, to which back ends with other metrics fit it
    box : what the letters may cover
    halo : the colour around the letters; None for no halo
    """

    text: str
    font: Font
    x: float
    y: float
    width: float
    box: Box
    color: Rgba
    halo: Rgba | None

    def moved(self, x: float, y: float) -> "Text":
        """Return the text, moved."""
        return replace(self, x=self.x + x, y=self.y + y, box=self.box.moved(x, y))


@dataclass(frozen=True)
class Line:
    """A straight line with flat ends."""

    x0: float
    y0: float
    x1: float
    y1: float
    width: float
    color: Rgba
    dash: tuple[float, ...] = ()

    def moved(self, x: float, y: float) -> "Line":
        """Return the line, moved."""
        return replace(self, x0=self.x0 + x, y0=self.y0 + y, x1=self.x1 + x, y1=self.y1 + y)


@dataclass(frozen=True)
class Rectangle:
    """A filled box."""

    box: Box
    color: Rgba

    def moved(self, x: float, y: float) -> "Rectangle":
        """Return the rectangle, moved."""
        return replace(self, box=self.box.moved(x, y))


@dataclass(frozen=True)
class Disc:
    """A filled circle."""

    x: float
    y: float
    diameter: float
    color: Rgba

    def moved(self, x: float, y: float) -> "Disc":
        """Return the disc, moved."""
        return replace(self, x=self.x + x, y=self.y + y)


Shape = Line | Rectangle | Disc


def box_of_shape(shape: Shape) -> Box:
    """Return the box that holds a shape."""
    if isinstance(shape, Rectangle):
        return shape.box
    if isinstance(shape, Disc):
        return Box(shape.x, shape.y, shape.x, shape.y).widened(0.5 * shape.diameter)
    ends = min(shape.x0, shape.x1), min(shape.y0, shape.y1), max(shape.x0, shape.x1), max(shape.y0, shape.y1)
    return Box(*ends).widened(0.5 * shape.width)


@dataclass(frozen=True)
class Annotation:
    """What is drawn over the models: shapes in their order, and all texts over them."""

    shapes: Sequence[Shape] = ()
    texts: Sequence[Text] = field(default=())

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to draw."""
        return not self.shapes and not self.texts

    def moved(self, x: float, y: float) -> "Annotation":
        """Return the annotation, moved."""
        return Annotation([shape.moved(x, y) for shape in self.shapes], [text.moved(x, y) for text in self.texts])

    def __add__(self, other: "Annotation") -> "Annotation":
        return Annotation((*self.shapes, *other.shapes), (*self.texts, *other.texts))


NO_ANNOTATION = Annotation()
