"""Web pages as pictures of `render`: what they take of its options, and how they are made."""

from argparse import Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..errors import ArgumentError
from .argument_types.paths import PAGE_TYPES
from .outputs import PlannedPicture

if TYPE_CHECKING:
    from ..drawing.layer import Layer

OWN_OPTIONS = ("max_edges", "title")
LEFT_OUT = ("axes", "axis_titles", "legend", "font", "font_size")
PICTURES_ALONE = (*LEFT_OUT, "views", "paper", "drawing_scale", "margin", "units")


def require_web_page_options(options: Namespace, pictures: Sequence[PlannedPicture]) -> None:
    """Raise `ArgumentError` for options that web pages do not have, and for those that only they have."""
    page = next((picture.output for picture in pictures if picture.file_type in PAGE_TYPES), None)
    if page is None:
        own = find_given(options, OWN_OPTIONS)
        if own is not None:
            raise ArgumentError(f"{own} is for web pages, whose names end in .html")
        return
    given = find_given(options, PICTURES_ALONE)
    if given is not None:
        raise ArgumentError(f"{page}: {given} cannot go with a web page")


def find_given(options: Namespace, names: Sequence[str]) -> str | None:
    """Return the first of some options that was typed; None if none was."""
    given = next((name for name in names if getattr(options, name) not in (None, False)), None)
    return given and f"--{given.replace('_', '-')}"


def make_web_page(options: Namespace, layers: Sequence["Layer"], **arguments: Any) -> bytes:
    """Return the page that `options` ask for."""
    from ..drawing.prepare import Frame
    from ..web.page import encode_page, show_models

    frame = Frame(*(arguments[name] for name in ("camera", "size", "background", "device")))
    return encode_page(show_models(list(layers), frame, {}), options.title, options.max_edges)
