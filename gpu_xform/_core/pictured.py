"""What shows a picture of itself in notebooks."""

from importlib import import_module

PREVIEWS = "gpu_xform.rendering.preview"  # by name: models know nothing of what draws them


class Pictured:
    """A base of classes that notebooks show as a small picture; terminals ask for no picture, and draw none."""

    def _repr_png_(self) -> bytes | None:
        png: bytes | None = import_module(PREVIEWS).draw_preview(self)
        return png
