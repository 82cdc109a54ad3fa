"""PDF documents: one optional-content layer per model, for print."""

import io
import zlib
from collections.abc import Iterator, Sequence
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np

from ..annotation.items import NO_ANNOTATION, Annotation
from ..errors import MissingExtraError
from ..imaging.colors import Rgba
from .annotation_pdf import AnnotationWriter
from .decimal_text import Bytes, format_rows, to_fixed_point
from .gouraud import pack_gouraud
from .layer import Points, Stroke, VectorLayer
from .paths import SEAM_WIDTH_PX, Paths, make_line_paths, make_polygon_paths, quantize_colors, unique_colors

POINTS_PER_PIXEL = 0.75  # CSS has 96 pixels per inch, PDF 72 points
ZLIB_LEVEL = 4  # the best level saves another 5 %, and takes seven times as long

# Four Bezier curves, a circle of diameter 1 within 0.03 %. A line of no length with round ends would be one too, but
# some viewers lengthen it.
_BEND = 0.5 * 0.5523
_CIRCLE = (
    *((0.5, 0.0), (0.5, _BEND), (_BEND, 0.5), (0.0, 0.5), (-_BEND, 0.5), (-0.5, _BEND), (-0.5, 0.0)),
    *((-0.5, -_BEND), (-_BEND, -0.5), (0.0, -0.5), (_BEND, -0.5), (0.5, -_BEND), (0.5, 0.0)),
)
_CIRCLE_VERBS = (b" m\n", *(b" ", b" ", b" c\n") * 3, b" ", b" ", b" c f\n")


def format_pdf(
    size: tuple[float, float], background: Rgba, layers: Sequence[VectorLayer], annotation: Annotation = NO_ANNOTATION
) -> bytes:
    """Return a PDF document of one page that shows each layer over those before it; the same bytes every time.

    A pixel of `size` = (width, height) is 1/96 inch. Each model is a layer of the document with the model's name, which
    viewers can hide. Coordinates are rounded to hundredths of a pixel. Raises `MissingExtraError` if pydyf is not
    installed.
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
    page.annotate(annotation)
    return page.document()


class _Page:
    """A page whose coordinates are pixels from the top left corner, and the resources that its content names."""

    def __init__(self, pydyf: ModuleType, size: tuple[float, float]) -> None:
        self._pydyf = pydyf
        self._size = size
        self._pdf = pydyf.PDF()
        self._alphas: dict[str, Any] = {}
        self._groups: dict[str, Any] = {}
        self._models: dict[str, Any] = {}
        self._shadings: dict[str, Any] = {}
        self._writer = AnnotationWriter(pydyf, self._pdf, self._opacity)
        self._content = [b"%f 0 0 %f 0 %f cm" % (POINTS_PER_PIXEL, -POINTS_PER_PIXEL, POINTS_PER_PIXEL * size[1])]

    def fill(self, background: Rgba) -> None:
        """Fill the whole page with a colour."""
        [state] = self._states(quantize_colors(np.array([background]), 1), "rg")
        self._content.append(b"q %b0 0 %b %b re f Q" % (state, *map(_to_number, self._size)))

    def draw(self, layer: VectorLayer) -> None:
        """Draw one model over what is there."""
        name = f"m{len(self._models)}"
        title = layer.name.encode("utf-8", "replace").decode() or "model"
        model = self._pydyf.Dictionary({"Type": "/OCG", "Name": self._pydyf.String(title)})
        self._pdf.add_object(model)
        self._models[name] = model.reference
        self._content.extend([b"/OC /%b BDC" % name.encode(), *self._draw_model(layer), b"EMC"])

    def annotate(self, annotation: Annotation) -> None:
        """Draw an annotation over what is there."""
        self._content.extend(self._writer.draw(annotation))

    def document(self) -> bytes:
        """Return the whole document."""
        pydyf, pdf = self._pydyf, self._pdf
        content = self._add_stream(self._content)
        resources = {"ExtGState": self._alphas, "XObject": self._groups, "Properties": self._models}
        if self._shadings:
            resources["Shading"] = self._shadings
        if self._writer.fonts:
            resources["Font"] = self._writer.fonts
        page = {
            "Type": "/Page",
            "Parent": pdf.pages.reference,
            "MediaBox": pydyf.Array([0, 0, *(POINTS_PER_PIXEL * side for side in self._size)]),
            "Contents": content.reference,
            "Resources": pydyf.Dictionary({kind: pydyf.Dictionary(named) for kind, named in resources.items()}),
        }
        pdf.add_page(pydyf.Dictionary(page))
        models = pydyf.Array(self._models.values())
        pdf.catalog["OCProperties"] = pydyf.Dictionary({"OCGs": models, "D": pydyf.Dictionary({"Order": models})})
        file = io.BytesIO()
        pdf.write(file)
        return file.getvalue()

    def _add_stream(self, commands: list[bytes], **entries: Any) -> Any:
        """Add a compressed stream of `commands` to the document."""
        data = zlib.compress(b"\n".join(commands), ZLIB_LEVEL)
        stream = self._pydyf.Stream([data], {**entries, "Filter": "/FlateDecode"})
        self._pdf.add_object(stream)
        return stream

    def _draw_model(self, layer: VectorLayer) -> Iterator[bytes]:
        if layer.polygons is not None:
            for alpha, paths in make_polygon_paths(layer.polygons):
                yield from self._draw_faces(paths, alpha)
        for hidden in (True, False):
            yield from self._draw_lines(make_line_paths(layer, hidden=hidden), layer.stroke(hidden=hidden))
        if layer.points is not None:
            yield from self._draw_points(layer.points)

    def _draw_faces(self, paths: Paths, alpha: int) -> Iterator[bytes]:
        if len(paths.colors) == 1 and not paths.is_gradient.any():
            commands = [b"q", *self._draw_paths(paths, "rg", b"f"), b"Q"]
        else:
            drawn = list(self._draw_paths(paths, "rg RG", b"b"))
            if paths.is_gradient.any():
                drawn = self._shade(paths, drawn)
            commands = [b"q %f w 1 j" % SEAM_WIDTH_PX, *drawn, b"Q"]
        if alpha == 255:
            yield from commands
            return
        # A transparency group, composited over the page as a whole: polygons do not show through one another.
        group = {
            "Type": "/XObject",
            "Subtype": "/Form",
            "BBox": self._pydyf.Array([0, 0, *self._size]),
            "Group": self._pydyf.Dictionary({"S": "/Transparency"}),
        }
        if paths.is_gradient.any():
            group["Resources"] = self._pydyf.Dictionary({"Shading": self._pydyf.Dictionary(self._shadings)})
        name = f"g{len(self._groups)}"
        self._groups[name] = self._add_stream(commands, **group).reference
        yield f"q {self._opacity(alpha)}/{name} Do Q".encode()

    def _shade(self, paths: Paths, drawn: list[bytes]) -> list[bytes]:
        """Return the commands of paths, and after each run of those with gradients a mesh of triangles over it.

        The paths are drawn too, because some viewers leave out rows of pixels between the triangles of meshes.
        """
        starts = np.flatnonzero(np.diff(paths.is_gradient, prepend=~paths.is_gradient[:1]))
        commands = []
        for start, end in pairwise([*starts.tolist(), len(drawn)]):
            commands += drawn[start:end]
            if not paths.is_gradient[start]:
                continue
            box, content = pack_gouraud(paths, start, end)
            name = f"s{len(self._shadings)}"
            mesh = {
                "ShadingType": 4,
                "ColorSpace": "/DeviceRGB",
                "BitsPerCoordinate": 32,
                "BitsPerComponent": 8,
                "BitsPerFlag": 8,
                "Decode": self._pydyf.Array([*box, 0, 1, 0, 1, 0, 1]),
            }
            self._shadings[name] = self._add_stream([content], **mesh).reference
            commands.append(b"/%b sh" % name.encode())
        return commands

    def _draw_lines(self, paths: Paths, stroke: Stroke) -> Iterator[bytes]:
        if paths.phases is None:
            yield b"q %f w 1 j 1 J" % stroke.line_width
            yield from self._draw_paths(paths, "RG", b"S")
        else:
            yield b"q %f w 1 j" % stroke.line_width
            pattern = b" ".join(b"%f" % dash for dash in stroke.dash)
            dashes = [b"[%b] %.2f d\n" % (pattern, phase / 100) for phase in paths.phases.tolist()]
            yield from map(bytes.__add__, dashes, self._draw_paths(paths, "RG", b"S"))
        yield b"Q"

    def _draw_paths(self, paths: Paths, operators: str, paint: bytes) -> Iterator[bytes]:
        """Yield the commands of each path: its colour, its lines, and the operator that paints them."""
        verbs = np.where(paths.begins, b" m", b" l")
        after = np.where(paths.ends & paths.closed, b" h\n", b"\n")
        text, row_offsets = format_rows(paths.points[:, 0], b" ", paths.points[:, 1], verbs, after)
        offsets = row_offsets[paths.offsets].tolist()
        states = self._states(paths.colors, operators)
        for state, start, end in zip(states, offsets[:-1], offsets[1:], strict=True):
            yield state + text[start:end] + paint

    def _draw_points(self, points: Points) -> Iterator[bytes]:
        colors = quantize_colors(points.colors, len(points.circles))
        is_shown = colors[:, 3] > 0
        if not is_shown.any():
            return
        x, y, diameter = points.circles[is_shown].T
        columns = [
            part
            for (dx, dy), verb in zip(_CIRCLE, _CIRCLE_VERBS, strict=True)
            for part in (to_fixed_point(x + dx * diameter), b" ", to_fixed_point(y + dy * diameter), verb)
        ]
        yield b"q"
        yield format_rows(np.array(self._states(colors[is_shown], "rg")), *columns)[0]
        yield b"Q"

    def _states(self, colors: Bytes, operators: str) -> list[bytes]:
        """Return the commands that set each of `colors`: none if it equals the one before."""
        unique, index = unique_colors(colors)
        all_opaque = bool((colors[:, 3] == 255).all())
        states = []
        for *rgb, alpha in unique.tolist():
            components = " ".join(f"{component / 255:.4g}" for component in rgb)
            paint = " ".join(f"{components} {operator}" for operator in operators.split())
            states.append(f"{paint} {'' if all_opaque else self._opacity(alpha)}".encode())
        changes = np.diff(index, prepend=-1) != 0
        return [states[i] if new else b"" for i, new in zip(index.tolist(), changes.tolist(), strict=True)]

    def _opacity(self, alpha: int) -> str:
        """Return the command that sets an alpha, from 0 to 255."""
        self._alphas[f"a{alpha}"] = self._pydyf.Dictionary({"CA": alpha / 255, "ca": alpha / 255})
        return f"/a{alpha} gs "


def _to_number(value: float) -> bytes:
    return f"{value:.10g}".encode()
