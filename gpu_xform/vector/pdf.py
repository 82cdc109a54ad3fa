"""Pictures as PDF, one layer a model, for print."""

import io
import zlib
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import MissingExtraError
from ..imaging.colors import FloatColor
from .decimal_text import Octets, hundredths, rows
from .layer import Dots, Strokes, dash_pattern
from .paths import SEAM, Paths, distinct, face_paths, line_paths, octets

POINTS_A_PIXEL = 0.75  # CSS has 96 pixels an inch, PDF 72 points
COMPRESSION = 4  # zlib's best saves another twentieth, and takes seven times as long

# Four curves, a circle of diameter 1 within 0.03 %. A line of no length with round ends would be one as well, but some
# viewers lengthen it.
_BEND = 0.5 * 0.5523
_CIRCLE = (
    *((0.5, 0.0), (0.5, _BEND), (_BEND, 0.5), (0.0, 0.5), (-_BEND, 0.5), (-0.5, _BEND), (-0.5, 0.0)),
    *((-0.5, -_BEND), (-_BEND, -0.5), (0.0, -0.5), (_BEND, -0.5), (0.5, -_BEND), (0.5, 0.0)),
)
_CIRCLE_VERBS = (b" m\n", *(b" ", b" ", b" c\n") * 3, b" ", b" ", b" c f\n")


def pdf(size: tuple[int, int], background: FloatColor, layers: Sequence[Strokes]) -> bytes:
    """Return a PDF document of one page that shows each layer over those before it; the same bytes every time.

    A pixel of `size` is 1/96 inch. A model is a layer of the document, which viewers can hide, under its own name.
    Coordinates are rounded to hundredths of a pixel. Raises `MissingExtraError` where pydyf is not installed.
    """
    try:
        import pydyf
    except ImportError:
        raise MissingExtraError("PDF needs pydyf: pip install 'gpu_xform[pdf]'") from None
    page = _Page(pydyf, size)
    if background[3] > 0.0:
        page.fill(background)
    for layer in layers:
        page.draw(layer)
    return page.document()


class _Page:
    """A page whose content counts in pixels from the top left corner, and what the content refers to by name."""

    def __init__(self, pydyf: ModuleType, size: tuple[int, int]) -> None:
        self._pydyf = pydyf
        self._size = size
        self._pdf = pydyf.PDF()
        self._alphas: dict[str, Any] = {}
        self._groups: dict[str, Any] = {}
        self._models: dict[str, Any] = {}
        self._content = [b"%f 0 0 %f 0 %f cm" % (POINTS_A_PIXEL, -POINTS_A_PIXEL, POINTS_A_PIXEL * size[1])]

    def fill(self, background: FloatColor) -> None:
        """Paint all of the page."""
        [state] = self._states(octets(np.array([background]), 1), "rg")
        self._content.append(b"q %b0 0 %d %d re f Q" % (state, *self._size))

    def draw(self, layer: Strokes) -> None:
        """Draw one model, over what is there."""
        name = f"m{len(self._models)}"
        title = layer.name.encode("utf-8", "replace").decode() or "model"
        model = self._pydyf.Dictionary({"Type": "/OCG", "Name": self._pydyf.String(title)})
        self._pdf.add_object(model)
        self._models[name] = model.reference
        self._content.extend([b"/OC /%b BDC" % name.encode(), *self._model(layer), b"EMC"])

    def document(self) -> bytes:
        """Return the whole document."""
        pydyf, pdf = self._pydyf, self._pdf
        content = self._stream(self._content)
        resources = {"ExtGState": self._alphas, "XObject": self._groups, "Properties": self._models}
        page = {
            "Type": "/Page",
            "Parent": pdf.pages.reference,
            "MediaBox": pydyf.Array([0, 0, *(POINTS_A_PIXEL * side for side in self._size)]),
            "Contents": content.reference,
            "Resources": pydyf.Dictionary({kind: pydyf.Dictionary(named) for kind, named in resources.items()}),
        }
        pdf.add_page(pydyf.Dictionary(page))
        models = pydyf.Array(self._models.values())
        pdf.catalog["OCProperties"] = pydyf.Dictionary({"OCGs": models, "D": pydyf.Dictionary({"Order": models})})
        file = io.BytesIO()
        pdf.write(file)
        return file.getvalue()

    def _stream(self, commands: list[bytes], **entries: Any) -> Any:
        """Add a stream of `commands` to the document, compressed."""
        data = zlib.compress(b"\n".join(commands), COMPRESSION)
        stream = self._pydyf.Stream([data], {**entries, "Filter": "/FlateDecode"})
        self._pdf.add_object(stream)
        return stream

    def _model(self, layer: Strokes) -> Iterator[bytes]:
        if layer.polygons is not None:
            for alpha, paths in face_paths(layer.polygons):
                yield from self._faces(paths, alpha)
        for hidden in (True, False):
            yield from self._lines(line_paths(layer, hidden=hidden), layer.line_width)
        if layer.dots is not None:
            yield from self._dots(layer.dots)

    def _faces(self, paths: Paths, alpha: int) -> Iterator[bytes]:
        if len(paths.colors) == 1:
            commands = [b"q", *self._painted(paths, "rg", b"f"), b"Q"]
        else:
            commands = [b"q %f w 1 j" % SEAM, *self._painted(paths, "rg RG", b"b"), b"Q"]
        if alpha == 255:
            yield from commands
            return
        # Painted apart, then laid over the page as one: no polygon shines through another.
        group = {
            "Type": "/XObject",
            "Subtype": "/Form",
            "BBox": self._pydyf.Array([0, 0, *self._size]),
            "Group": self._pydyf.Dictionary({"S": "/Transparency"}),
        }
        name = f"g{len(self._groups)}"
        self._groups[name] = self._stream(commands, **group).reference
        yield f"q {self._opacity(alpha)}/{name} Do Q".encode()

    def _lines(self, paths: Paths, line_width: float) -> Iterator[bytes]:
        if paths.phases is None:
            yield b"q %f w 1 j 1 J" % line_width
            yield from self._painted(paths, "RG", b"S")
        else:
            on, off = dash_pattern(line_width)
            yield b"q %f w" % line_width
            dashes = [b"[%f %f] %.2f d\n" % (on, off, phase / 100) for phase in paths.phases.tolist()]
            yield from map(bytes.__add__, dashes, self._painted(paths, "RG", b"S"))
        yield b"Q"

    def _painted(self, paths: Paths, operators: str, paint: bytes) -> Iterator[bytes]:
        """Yield the commands for each path: its colour, its lines, and what paints them."""
        verbs = np.where(paths.begins, b" m", b" l")
        after = np.where(paths.ends & paths.closed, b" h\n", b"\n")
        text, rows_at = rows(paths.points[:, 0], b" ", paths.points[:, 1], verbs, after)
        at = rows_at[paths.offsets].tolist()
        for state, a, b in zip(self._states(paths.colors, operators), at[:-1], at[1:], strict=True):
            yield state + text[a:b] + paint

    def _dots(self, dots: Dots) -> Iterator[bytes]:
        colors = octets(dots.colors, len(dots.circles))
        shown = colors[:, 3] > 0
        if not shown.any():
            return
        x, y, diameter = dots.circles[shown].T
        columns = [
            part
            for (across, down), verb in zip(_CIRCLE, _CIRCLE_VERBS, strict=True)
            for part in (hundredths(x + across * diameter), b" ", hundredths(y + down * diameter), verb)
        ]
        yield b"q"
        yield rows(np.array(self._states(colors[shown], "rg")), *columns)[0]
        yield b"Q"

    def _states(self, colors: Octets, operators: str) -> list[bytes]:
        """Return what to set before each of `colors` is used: nothing where it is the one before."""
        found, which = distinct(colors)
        all_opaque = bool((colors[:, 3] == 255).all())
        words = []
        for *rgb, alpha in found.tolist():
            components = " ".join(f"{component / 255:.4g}" for component in rgb)
            paint = " ".join(f"{components} {operator}" for operator in operators.split())
            words.append(f"{paint} {'' if all_opaque else self._opacity(alpha)}".encode())
        changed = np.diff(which, prepend=-1) != 0
        return [words[i] if new else b"" for i, new in zip(which.tolist(), changed.tolist(), strict=True)]

    def _opacity(self, alpha: int) -> str:
        """Return what sets an alpha, from 0 to 255."""
        self._alphas[f"a{alpha}"] = self._pydyf.Dictionary({"CA": alpha / 255, "ca": alpha / 255})
        return f"/a{alpha} gs "
