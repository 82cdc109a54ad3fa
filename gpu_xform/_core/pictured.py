"""What shows a picture of itself in notebooks."""

import sys
from importlib import import_module
from typing import Any

from ..errors import NoAdapterError

PREVIEWS = "gpu_xform.rendering.preview"  # by name: models know nothing of what draws them
PNG = "image/png"


class Pictured:
    """A base of classes that notebooks show as a small picture; terminals ask for no picture, and draw none."""

    def _repr_png_(self) -> bytes | None:
        return _draw(self)


def show_lists() -> None:
    """Let IPython, where it runs, show a list of nothing but pictured objects as one picture; others stay as they are.

    A list cannot say by itself how it is shown.
    """
    ipython = sys.modules.get("IPython")
    shell: Any = ipython.get_ipython() if ipython else None
    formatter = shell and shell.display_formatter.formatters.get(PNG)
    if formatter and list not in formatter.type_printers:
        formatter.for_type(list, _draw_list)


def _draw_list(items: list[object]) -> bytes | None:
    return _draw(items) if items and all(isinstance(item, Pictured) for item in items) else None


def _draw(thing: object) -> bytes | None:
    try:
        previews = import_module(PREVIEWS)
    except NoAdapterError:  # where wgpu cannot be imported
        return None
    png: bytes | None = previews.draw_preview(thing)
    return png


show_lists()
