"""Layers as the shapes that a device draws."""

import contextlib
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.edges import edge_parts
from ..gpu.buffers import Buffer
from ..gpu.device import Device
from ..gpu.layouts import CANDIDATE
from ..imaging.colors import packed
from . import silhouettes as silhouette_pass
from .depth import eye
from .draw_list import Cue, Faces, Lines, Shape
from .enums import ColorMode, Hidden
from .geometry_source import Candidates, Subject
from .layer import Layer
from .layer_colors import NO_ROWS, LineColors, fill_colors, has_several_colors, line_colors

EDGE_BYTES = 8
TRIANGLE_BYTES = 12
CLOUD_POINT_SIZE = 2.0  # pixels, of points that nothing joins


@dataclass(frozen=True)
class Shaped:
    """A picture's shapes, which layer each comes from, and the colours that their faces are painted in.

    palette : (c,) packed
    """

    shapes: list[Shape]
    layers: list[int]
    palette: npt.NDArray[np.uint32]


def shaped(
    layers: Sequence[Layer],
    subjects: Sequence[Subject],
    clip_from_world: Float64Array,
    cues: Sequence[Float64Array],
    device: Device,
    stack: contextlib.ExitStack,
) -> Shaped:
    """Put the layers on the device; what is there for this picture alone is released as `stack` unwinds.

    clip_from_world : (4, 4), depth turned round
    cues : (4,) for each layer, as `views.depth_cue` gives them

    Raises `MeshError` for a model without anything to draw, `ArgumentError` as the parts of a layer do.
    """
    shapes: list[Shape] = []
    owners: list[int] = []
    palette: list[npt.NDArray[np.uint32]] = []
    for number, (layer, subject, cue) in enumerate(zip(layers, subjects, cues, strict=True)):
        first_color = sum(map(len, palette))
        shaper = _Shaper(layer, subject, device, stack)
        with _named(subject.name or f"models[{number}]") if len(layers) > 1 else contextlib.nullcontext():
            if layer.fill is not None:
                palette.append(shaper.fill())
            made = shaper.shapes(clip_from_world, cue, first_color)
        shapes += made
        owners += [number] * len(made)
    return Shaped(shapes, owners, np.concatenate(palette) if palette else np.empty(0, np.uint32))


@contextlib.contextmanager
def _named(name: str) -> Iterator[None]:
    """Say of which of several models an error tells."""
    try:
        yield
    except (ArgumentError, ArgumentTypeError, MeshError) as error:
        raise type(error)(f"{name}: {error}") from None


def unscaled(matrices: Float64Array) -> Float64Array:
    """Return matrices (k, 4, 4), affine ones with 1 in the end: as what is homogeneous they stay what they are."""
    last = matrices[:, 3:, 3:]
    is_affine = (matrices[:, 3:, :3] == 0.0).all(axis=2, keepdims=True) & (last > 0.0)
    return matrices / np.where(is_affine, last, 1.0)


def hides(layer: Layer) -> Hidden:
    """Return what is done with the layer's hidden edges."""
    return Hidden.from_style(layer.hidden or ("show" if layer.fill is None else "remove"))


def needs_distance(layer: Layer) -> bool:
    """Say whether distance pales a layer, or nearer lines of it must lie over farther ones that look different."""
    differs = has_several_colors(layer) or (not layer.antialias and hides(layer) in {Hidden.DASH, Hidden.FADE})
    return differs or layer.depth_cue > 0.0


class _Shaper:
    """One layer on its way to the device."""

    def __init__(self, layer: Layer, subject: Subject, device: Device, stack: contextlib.ExitStack) -> None:
        self._layer = layer
        self._subject = subject
        self._device = device
        self._stack = stack

    def fill(self) -> npt.NDArray[np.uint32]:
        """Return the packed colours that the faces are painted in: one, or one for each."""
        colors = fill_colors(self._layer, self._subject.n_faces)
        return packed(colors * (1.0, 1.0, 1.0, self._layer.alpha))

    def shapes(self, clip_from_world: Float64Array, cue: Float64Array, first_color: int) -> list[Shape]:
        """Return the layer's instances as one shape, and where silhouettes are drawn those of each as another."""
        layer, subject = self._layer, self._subject
        pairs, candidates, point_size = subject.pairs(layer), subject.candidates(layer), layer.point_size
        edges = self._kept(pairs.role, lambda: pairs.find().astype(np.uint32))
        n_edges = edges.n_bytes // EDGE_BYTES
        if n_edges == 0 and point_size is None:
            if subject.n_faces == 0:
                point_size = CLOUD_POINT_SIZE
            elif candidates is None and layer.fill is None:
                raise MeshError(self._nothing_to_draw())
        points, model_from_points = subject.on_device(self._device)
        with np.errstate(over="ignore", invalid="ignore"):
            clip_from_points = clip_from_world @ unscaled(layer.world_from_model) @ model_from_points
        if not np.isfinite(clip_from_points).all():
            raise ArgumentError("transform must be a matrix of numbers that do not overflow in the picture")
        scale = float(np.abs(clip_from_points).max()) or 1.0  # homogeneous: a factor changes nothing
        clip_from_points = clip_from_points / scale
        own_cue = (float(cue[0]), float(cue[1] * scale), float(cue[2]), float(cue[3]))
        style = Lines(
            edges=edges,
            n_edges=n_edges,
            line_width=layer.line_width if layer.antialias else None,
            hidden=hides(layer),
            strength=layer.alpha,
            cue=own_cue,
        )
        colors = line_colors(layer, subject.n_points, subject.n_faces, pairs.n_rows)
        lines: tuple[Lines, ...] = ()
        if n_edges:
            lines = (self._colored(style, colors, lambda: pairs.rows and pairs.rows(pairs.find())),)
        dots: tuple[Lines, ...] = ()
        if point_size is not None:
            dots = (self._dots(replace(style, line_width=point_size), colors),)
        faces = self._faces(first_color, own_cue)
        if candidates is None:
            return [Shape(points, clip_from_points, faces, lines + dots)]
        shapes = [Shape(points, clip_from_points, faces, lines)]
        for matrix in clip_from_points:
            seen = self._silhouette(style, candidates, colors, matrix)
            shapes.append(Shape(points, matrix[None], None, seen))
        if dots:
            shapes.append(Shape(points, clip_from_points, None, dots))
        return shapes

    def _nothing_to_draw(self) -> str:
        edges, subject = self._layer.edges, self._subject
        if edges is None or subject.mesh is None:
            return f"model must have edges to draw, got {subject.n_points} points and {subject.n_faces} faces"
        chosen = [repr(str(part)) if isinstance(part, str) else "an array" for part in edge_parts(edges)]
        said = f"{' and '.join(chosen) or 'an array'} choose{'s' if len(chosen) < 2 else ''}"
        reason = ""
        if "'feature'" in chosen:
            reason = f": no two faces turn by more than {self._layer.feature_angle:g} degrees"
        elif "'boundary'" in chosen:
            reason = ": no edge is on one face alone"
        way_out = "; 'silhouette' draws the outline" if reason else ""
        return f"edges must choose at least one edge, {said} none of {len(subject.mesh.edges)}{reason}{way_out}"

    def _colored(self, style: Lines, colors: LineColors, places: Callable[[], IndexArray | None]) -> Lines:
        """Return `style` in `colors`; `places` gives which row each edge has, or None where they are in order."""

        def rows() -> npt.NDArray[np.uint32]:
            picked = places() if colors.mode is ColorMode.PER_EDGE else None
            return colors.rows if picked is None else colors.rows[picked]

        own = None if colors.mode is ColorMode.UNIFORM else self._kept(colors.role, rows)
        return replace(style, color=colors.one, colors=own, color_mode=colors.mode, is_clear=colors.is_clear)

    def _dots(self, style: Lines, colors: LineColors) -> Lines:
        """Return a line without length at each point; one that is hidden has no length for a dash either."""
        hidden = Hidden.REMOVE if style.hidden is Hidden.DASH else style.hidden
        n_points = self._subject.n_points
        edges = self._kept("dots", lambda: np.repeat(np.arange(n_points, dtype=np.uint32), 2))
        if colors.mode is ColorMode.PER_EDGE:
            colors = LineColors(ColorMode.UNIFORM, colors.one, NO_ROWS)
        dots = replace(style, edges=edges, n_edges=n_points, hidden=hidden, are_dots=True)
        return self._colored(dots, colors, lambda: None)

    def _silhouette(
        self, style: Lines, candidates: Candidates, colors: LineColors, clip_from_points: Float64Array
    ) -> tuple[Lines, ...]:
        """Return the edges that are seen edge-on, if there are candidates."""
        among = self._kept(candidates.role, candidates.find)
        n_candidates = among.n_bytes // CANDIDATE.itemsize
        if n_candidates == 0:
            return ()
        planes = self._kept("planes", candidates.planes)
        found = silhouette_pass.find(self._device, among, n_candidates, planes, eye(clip_from_points))
        self._stack.callback(found.release)

        def places() -> IndexArray:
            return candidates.rows(candidates.find()["edge"].astype(np.int64))

        return (self._colored(replace(style, edges=found, n_edges=n_candidates, are_outlines=True), colors, places),)

    def _faces(self, first_color: int, cue: Cue) -> Faces | None:
        layer, subject = self._layer, self._subject
        if hides(layer) is Hidden.SHOW and layer.fill is None:
            return None
        corners = self._kept("triangles", lambda: subject.triangles()[0].astype(np.uint32))
        n_triangles = corners.n_bytes // TRIANGLE_BYTES
        if n_triangles == 0:
            return None
        places = None
        if layer.fill is not None:
            places = self._kept("one colour", lambda: np.zeros(1, np.uint32))
            if len(fill_colors(layer, subject.n_faces)) > 1:
                places = self._kept("triangles' faces", lambda: subject.triangles()[1].astype(np.uint32))
        return Faces(corners, n_triangles, places, first_color, cue)

    def _kept(self, role: Hashable | None, array: Callable[[], npt.NDArray[Any]]) -> Buffer:
        """Return the array on the device: from one picture to the next where it has a role, else for this picture."""
        if role is not None:
            return self._device.resource_cache.get(self._subject.owner, role, array)
        content = array()
        buffer = Buffer(self._device.context, max(content.nbytes, 4), label="draw list")
        self._stack.callback(buffer.release)
        if content.nbytes:
            buffer.upload(content)
        return buffer
