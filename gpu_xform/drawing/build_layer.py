"""One layer as drawables: its lines, faces and dots, with their colours, on the device."""

import contextlib
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import ArgumentError, MeshError
from ..geometry.edges import list_edge_parts
from ..gpu.buffers import Buffer
from ..gpu.device import GpuDevice
from ..gpu.device_points import DevicePoints
from ..gpu.layouts import CANDIDATE
from ..imaging.colors import pack_rgba8, to_rgba
from .dash_chains import pack_chains
from .dash_patterns import as_dash_pattern, hidden_dashes, scale_dashes
from .depth import DepthCue, eye
from .draw_list import EDGE_BYTES, TRIANGLE_BYTES, Drawable, Faces, Lines
from .edge_sample import fit_line_width, project_sample
from .enums import HIDDEN_FADE_ALPHA, ColorMode, Hidden
from .geometry_source import EdgeSource, GeometrySource, MeshSource, SilhouetteCandidates
from .intersections import MeetingLines
from .layer import Layer, dot_diameter, is_auto
from .layer_colors import NO_COLORS, LineColors, fill_colors, line_colors
from .layer_placement import find_clip_from_points, hidden_mode
from .lengths import to_pixels
from .limits import max_batch_edges, max_points
from .mesh_parts import split_by_points
from .shading import light_from_normals, pack_normals, shade_faces, triangle_normals
from .silhouettes import extract_silhouette, find_silhouette

CLOUD_POINT_SIZE_PX = 2.0  # of points that nothing joins


class LayerBuilder:
    """Builds the drawables of one layer."""

    def __init__(
        self,
        layer: Layer,
        source: GeometrySource,
        device: GpuDevice,
        stack: contextlib.ExitStack,
        size: tuple[int, int],
        *,
        is_covered: bool,
    ) -> None:
        self._layer = layer
        self._is_covered = is_covered
        self._source = source
        self._device = device
        self._stack = stack
        self._size = size
        # The triangles (t, 3) of each part of a mesh that is cut, and the face of each, by the number of their buffer.
        self._cut_faces: dict[int, tuple[npt.NDArray[Any], IndexArray]] = {}

    def fill_palette(self, clip_from_world: Float64Array) -> npt.NDArray[np.uint32]:
        """Return the packed colours of the faces: one, or one per face, of each instance if each face is shaded."""
        colors = fill_colors(self._layer, self._source.n_faces) * (1.0, 1.0, 1.0, self._layer.alpha)
        mesh = self._source.mesh
        if self._layer.shading != "none" and mesh is None:
            raise ArgumentError.expecting("shading", "be 'none' for a model without faces", repr(self._layer.shading))
        if self._layer.shading != "flat" or mesh is None:
            return pack_rgba8(colors)
        shaded = [shade_faces(colors, mesh, matrix, clip_from_world) for matrix in self._layer.world_from_model]
        return pack_rgba8(np.concatenate(shaded))

    def build(self, clip_from_world: Float64Array, depth_cue: DepthCue, first_color: int) -> list[Drawable]:
        """Return the layer's instances as one drawable, and what differs between them, as silhouettes do, as others."""
        layer, source = self._layer, self._source
        if isinstance(source, MeshSource) and source.n_points > max_points(self._device):
            return self._build_parts(source, clip_from_world, depth_cue, first_color)
        edge_source, candidates = source.edges(layer), source.silhouette_candidates(layer)
        edges = self._on_device(edge_source.key, edge_source.pack or (lambda: edge_source.find().astype(np.uint32)))
        n_edges = edges.n_bytes // EDGE_BYTES
        point_size = dot_diameter(layer) if n_edges else self._point_size_without_edges(candidates)
        points, model_from_points = source.on_device(self._device)
        clip_from_points, scale = find_clip_from_points(layer, clip_from_world, model_from_points)
        depth_cue = depth_cue._replace(distance_scale=depth_cue.distance_scale * scale)
        style = self._style(edges, n_edges, clip_from_points, depth_cue)
        strokes = self._strokes(style)
        colors = line_colors(layer, source.n_points, source.n_faces, edge_source.n_colors)
        lines: tuple[Lines, ...] = ()
        is_seen = self._is_seen(colors)
        if n_edges and is_seen:
            find_rows = edge_source.color_rows
            if any(stroke.dash_px for stroke, _ in strokes):
                chains = self._chains(edge_source)
                strokes = [(replace(stroke, chains=chains), own_colors) for stroke, own_colors in strokes]
            lines = tuple(
                self._colored(stroke, own_colors or colors, lambda: find_rows and find_rows(edge_source.find()))
                for stroke, own_colors in strokes
            )
        dots: tuple[Lines, ...] = ()
        if point_size is not None and is_seen:
            dots = (self._dots(replace(style, line_width=point_size), colors),)
        faces = self._faces(first_color, depth_cue)
        drawables = []
        if faces is not None and layer.shading != "none":
            lit = self._lit_faces(faces, clip_from_world)
            if len(lit) == 1:
                [faces] = lit
            else:
                drawables += [
                    Drawable(points, matrix[None], each, ()) for matrix, each in zip(clip_from_points, lit, strict=True)
                ]
                faces = None
        apart = self._tangent_edges_apart(lines, clip_from_points)
        lines = apart[0] if len(apart) == 1 else () if apart else lines
        lined = [] if len(apart) == 1 else list(zip(clip_from_points, apart, strict=False))
        if candidates is None or not is_seen:
            drawables.append(Drawable(points, clip_from_points, faces, lines + dots, source.sample_edges))
            return drawables + [Drawable(points, matrix[None], None, own, source.sample_edges) for matrix, own in lined]
        drawables.append(Drawable(points, clip_from_points, faces, lines, source.sample_edges))
        drawables += [Drawable(points, matrix[None], None, own, source.sample_edges) for matrix, own in lined]
        for matrix in clip_from_points:
            silhouette = self._silhouette(strokes, candidates, colors, matrix)
            drawables.append(Drawable(points, matrix[None], None, silhouette, source.sample_edges))
        if dots:
            drawables.append(Drawable(points, clip_from_points, None, dots))
        return drawables

    def _lit_faces(self, faces: Faces, clip_from_world: Float64Array) -> list[Faces]:
        """Return shaded faces for each instance: each is in a light of its own."""
        if self._layer.shading == "flat":
            n_instances, n_colors = len(self._layer.world_from_model), self._source.n_faces
            return [replace(faces, first_color=faces.first_color + i * n_colors) for i in range(n_instances)]
        return [
            replace(faces, light_from_normals=light_from_normals(matrix, clip_from_world))
            for matrix in self._layer.world_from_model
        ]

    def _is_seen(self, colors: LineColors) -> bool:
        is_clear = colors.mode is ColorMode.UNIFORM and colors.uniform[3] == 0.0
        return self._layer.alpha > 0.0 and not is_clear

    def _style(self, edges: Buffer, n_edges: int, clip_from_points: Float64Array, depth_cue: DepthCue) -> Lines:
        """Return the lines of some edges in the style of the layer, but for colours and dashes."""
        layer = self._layer
        return Lines(
            edges=edges,
            n_edges=n_edges,
            line_width=self._line_width(n_edges, clip_from_points) if layer.antialias else None,
            hidden=Hidden.REMOVE if self._is_covered else hidden_mode(layer),
            opacity=layer.alpha,
            is_covered=self._is_covered,
            are_silhouettes=isinstance(layer, MeetingLines),
            depth_cue=depth_cue,
        )

    def _build_parts(
        self, source: MeshSource, clip_from_world: Float64Array, depth_cue: DepthCue, first_color: int
    ) -> list[Drawable]:
        """Return what `build` does of a mesh of more points than one drawable holds, as drawables of fewer each.

        Silhouettes are found on the host. Lines of several colours, and dashes, begin anew with each part.
        """
        layer = self._layer
        edge_source, candidates = source.edges(layer), source.silhouette_candidates(layer)
        edges = edge_source.find()
        point_size = dot_diameter(layer) if len(edges) else self._point_size_without_edges(candidates)
        clip_from_points, scale = find_clip_from_points(layer, clip_from_world, source.model_from_points)
        depth_cue = depth_cue._replace(distance_scale=depth_cue.distance_scale * scale)
        style = self._style(
            self._on_device(None, lambda: np.empty(0, np.uint32)), len(edges), clip_from_points, depth_cue
        )
        colors = line_colors(layer, source.n_points, source.n_faces, edge_source.n_colors)
        drawables = self._face_parts(source, clip_from_points, clip_from_world, first_color, depth_cue)
        if not self._is_seen(colors):
            return drawables
        find_rows = edge_source.color_rows
        is_per_edge = colors.mode is ColorMode.PER_EDGE
        rows = find_rows(edges) if find_rows and is_per_edge else None
        strokes = self._strokes(style)
        for stroke, own_colors in strokes:
            drawables += self._line_parts(source, edges, stroke, own_colors or colors, rows, clip_from_points)
        if candidates is not None:
            among, planes = candidates.find(), candidates.planes()
            for matrix in clip_from_points:
                found = find_silhouette(among, planes, eye(matrix))
                rows = candidates.color_rows(found) if is_per_edge else None
                for stroke, own_colors in strokes:
                    seen = replace(stroke, are_silhouettes=True)
                    drawables += self._line_parts(source, found, seen, own_colors or colors, rows, matrix[None])
        if point_size is not None:
            hidden = Hidden.REMOVE if style.hidden is Hidden.DASH else style.hidden
            dots = replace(style, line_width=point_size, hidden=hidden, are_points=True)
            if colors.mode is ColorMode.PER_EDGE:
                colors = LineColors(ColorMode.UNIFORM, colors.uniform, NO_COLORS)
            ends = np.repeat(np.arange(source.n_points), 2).reshape(-1, 2)
            drawables += self._line_parts(source, ends, dots, colors, None, clip_from_points)
        return drawables

    def _line_parts(
        self,
        source: MeshSource,
        edges: IndexArray,
        style: Lines,
        colors: LineColors,
        rows: IndexArray | None,
        clip_from_points: Float64Array,
    ) -> list[Drawable]:
        """Return edges (m, 2) as drawables; `rows` says which of the packed colours each has, None in their order."""
        drawables = []
        for part in split_by_points(edges, source.n_points, max_points(self._device)):
            lines = replace(
                style,
                edges=self._on_device(None, lambda part=part: part.indices),  # type: ignore[misc]
                n_edges=len(part.indices),
                color=colors.uniform,
                color_mode=colors.mode,
                has_transparency=colors.has_transparency,
            )
            if colors.mode is not ColorMode.UNIFORM:
                order = (
                    part.points
                    if colors.mode is ColorMode.PER_VERTEX
                    else part.rows
                    if rows is None
                    else rows[part.rows]
                )
                lines = replace(lines, colors=self._on_device(None, lambda order=order: colors.packed[order]))  # type: ignore[misc]
            if style.dash_px:
                own, ends = source.mesh.positions[part.points], part.indices.astype(np.int64)
                chains = pack_chains(ends, own, max_batch_edges(self._device))
                lines = replace(lines, chains=self._on_device(None, lambda chains=chains: chains))  # type: ignore[misc]
            points = self._some_points(source, part.points)
            drawables.append(Drawable(points, clip_from_points, None, (lines,), source.sample_edges))
        return drawables

    def _face_parts(
        self,
        source: MeshSource,
        clip_from_points: Float64Array,
        clip_from_world: Float64Array,
        first_color: int,
        depth_cue: DepthCue,
    ) -> list[Drawable]:
        """Return the faces as drawables, if any hides or is filled: of each instance by itself, if they are shaded."""
        layer = self._layer
        if hidden_mode(layer) is Hidden.SHOW and layer.fill is None:
            return []
        fill = None if layer.fill is None else fill_colors(layer, source.n_faces)
        has_several = fill is not None and (len(fill) > 1 or layer.shading == "flat")
        is_opaque = fill is not None and layer.alpha >= 1.0 and bool((fill[:, 3] >= 1.0).all())
        corners, face_of = source.triangles()
        normals = self._packed_normals() if fill is not None and layer.shading == "smooth" else None
        instances = [clip_from_points] if layer.shading == "none" else [matrix[None] for matrix in clip_from_points]
        drawables = []
        for part in split_by_points(corners, source.n_points, max_points(self._device)):
            triangles = self._on_device(None, lambda part=part: part.indices)  # type: ignore[misc]
            own = face_of[part.rows].astype(np.uint32) if has_several else np.zeros(1, np.uint32)
            indices = None if fill is None else self._on_device(None, lambda own=own: own)  # type: ignore[misc]
            points = self._some_points(source, part.points)
            self._cut_faces[triangles.id] = part.indices, face_of[part.rows]
            faces = Faces(triangles, len(part.indices), indices, first_color, depth_cue, is_opaque=is_opaque)
            if normals is not None:
                own = normals[part.rows]
                faces = replace(faces, corner_normals=self._on_device(None, lambda own=own: own))  # type: ignore[misc]
            lit = [faces] if layer.shading == "none" else self._lit_faces(faces, clip_from_world)
            drawables += [Drawable(points, matrices, each, ()) for matrices, each in zip(instances, lit, strict=True)]
        return drawables

    def _some_points(self, source: MeshSource, rows: IndexArray) -> DevicePoints:
        """Put some of the points of a mesh on the device, for this picture."""
        buffer = self._on_device(None, lambda: source.pack_points(rows))
        return DevicePoints(buffer, len(rows), np.dtype(np.float32), source.bounding_points)

    def build_covers(self, built: Sequence[Drawable], opaque: BoolArray) -> list[Drawable]:
        """Return the faces of drawables that are opaque, as `opaque` says: (n_faces,), or (1,) for all."""
        with_faces = [drawable for drawable in built if drawable.faces]
        if opaque.all():
            return [replace(drawable, lines=()) for drawable in with_faces]
        covers: list[Drawable] = []
        kept: dict[int, Faces] = {}
        for drawable in with_faces:
            buffer = drawable.faces.triangles  # type: ignore[union-attr]
            if buffer.id not in kept:
                corners, faces = self._cut_faces.get(buffer.id) or self._source.triangles()
                chosen = corners[opaque[faces]].astype(np.uint32)
                kept[buffer.id] = Faces(self._on_device(None, lambda chosen=chosen: chosen), len(chosen))  # type: ignore[misc]
            if kept[buffer.id].n_triangles:
                covers.append(replace(drawable, faces=kept[buffer.id], lines=()))
        return covers

    def _strokes(self, style: Lines) -> list[tuple[Lines, LineColors | None]]:
        """Return how lines are drawn, one after the other: hidden parts before visible ones if they differ in style.

        Colours are those of the layer if there are none.
        """
        layer, hidden_style = self._layer, self._layer.hidden_style
        width = style.line_width or 1.0
        dash_px = scale_dashes(as_dash_pattern(layer.dash, "dash"), width)
        if style.hidden is not Hidden.DASH and hidden_style is None:
            return [(replace(style, dash_px=dash_px) if dash_px else style, None)]
        if hidden_style is None and not dash_px:
            return [(replace(style, dash_px=hidden_dashes(width)), None)]
        own = hidden_style or {}
        hidden = replace(style, hidden=Hidden.ONLY)
        if layer.antialias and "line_width" in own:
            hidden = replace(hidden, line_width=to_pixels(own["line_width"], "hidden_style['line_width']"))
        width = hidden.line_width or 1.0
        if style.hidden is Hidden.FADE:
            hidden = replace(hidden, opacity=HIDDEN_FADE_ALPHA * hidden.opacity)
        if "dash" in own:
            hidden = replace(hidden, dash_px=scale_dashes(as_dash_pattern(own["dash"], "hidden_style"), width))
        elif style.hidden is Hidden.DASH:
            hidden = replace(hidden, dash_px=hidden_dashes(width))
        color = to_rgba(own["color"], "hidden_style") if "color" in own else None
        own_colors = None if color is None else LineColors(ColorMode.UNIFORM, color, NO_COLORS)
        return [(hidden, own_colors), (replace(style, hidden=Hidden.REMOVE, dash_px=dash_px), None)]

    def _line_width(self, n_edges: int, clip_from_points: Float64Array) -> float:
        if not is_auto(self._layer.line_width):
            return to_pixels(self._layer.line_width, "line_width")
        ends_px = project_sample(self._source.sample_edges, clip_from_points[0], self._size)
        hides_half = hidden_mode(self._layer) is not Hidden.SHOW and self._source.n_faces > 0
        return fit_line_width(ends_px, n_edges, self._size, hides_half=hides_half)

    def _point_size_without_edges(self, candidates: SilhouetteCandidates | None) -> float | None:
        """Return the diameter of the dots, None for none; raise `MeshError` if there is nothing else to draw."""
        layer = self._layer
        if layer.point_size is None and self._source.n_faces == 0:
            return CLOUD_POINT_SIZE_PX
        if layer.point_size is None and candidates is None and layer.fill is None:
            raise MeshError(self._nothing_to_draw())
        return dot_diameter(layer)

    def _nothing_to_draw(self) -> str:
        edges, source = self._layer.edges, self._source
        if edges is None or source.mesh is None:
            return f"model must have edges to draw, got {source.n_points} points and {source.n_faces} faces"
        names = [repr(str(part)) if isinstance(part, str) else "an array" for part in list_edge_parts(edges)]
        subject = f"{' and '.join(names) or 'an array'} choose{'s' if len(names) < 2 else ''}"
        reason = ""
        if "'feature'" in names:
            reason = f": no two faces turn by more than {self._layer.feature_angle:g} degrees"
        elif "'boundary'" in names:
            reason = ": no edge is on one face alone"
        way_out = "; 'silhouette' draws the outline" if reason else ""
        return f"edges must choose at least one edge, {subject} none of {len(source.mesh.edges)}{reason}{way_out}"

    def _colored(self, style: Lines, colors: LineColors, find_rows: Callable[[], IndexArray | None]) -> Lines:
        """Return `style` in `colors`; `find_rows` returns the row of each edge, or None if they are in order."""
        if colors.mode is ColorMode.UNIFORM:
            return replace(style, color=colors.uniform)

        def per_edge_or_vertex() -> npt.NDArray[np.uint32]:
            rows = find_rows() if colors.mode is ColorMode.PER_EDGE else None
            return colors.packed if rows is None else colors.packed[rows]

        buffer = self._on_device(colors.key, per_edge_or_vertex)
        return replace(
            style,
            color=colors.uniform,
            colors=buffer,
            color_mode=colors.mode,
            has_transparency=colors.has_transparency,
        )

    def _dots(self, style: Lines, colors: LineColors) -> Lines:
        """Return a line without length at each point; a hidden one has no length for a dash either."""
        hidden = Hidden.REMOVE if style.hidden is Hidden.DASH else style.hidden
        n_points = self._source.n_points
        edges = self._on_device("dots", lambda: np.repeat(np.arange(n_points, dtype=np.uint32), 2))
        if colors.mode is ColorMode.PER_EDGE:
            colors = LineColors(ColorMode.UNIFORM, colors.uniform, NO_COLORS)
        dots = replace(style, edges=edges, n_edges=n_points, hidden=hidden, are_points=True)
        return self._colored(dots, colors, lambda: None)

    def _silhouette(
        self,
        strokes: Sequence[tuple[Lines, LineColors | None]],
        candidates: SilhouetteCandidates,
        colors: LineColors,
        clip_from_points: Float64Array,
    ) -> tuple[Lines, ...]:
        """Return the edges that are seen edge-on, if there are candidates."""
        among = self._on_device(candidates.key, candidates.find)
        n_candidates = among.n_bytes // CANDIDATE.itemsize
        if n_candidates == 0:
            return ()
        planes = self._on_device(candidates.planes_key, candidates.planes)
        edges = extract_silhouette(self._device, among, n_candidates, planes, eye(clip_from_points))
        self._stack.callback(edges.release)

        def find_rows() -> IndexArray:
            return candidates.color_rows(candidates.find()["edge"].astype(np.int64))

        is_dashed = any(stroke.dash_px for stroke, _ in strokes)
        chains = self._silhouette_chains(edges, n_candidates) if is_dashed else None
        return tuple(
            self._colored(
                replace(stroke, edges=edges, n_edges=n_candidates, are_silhouettes=True, chains=chains),
                own_colors or colors,
                find_rows,
            )
            for stroke, own_colors in strokes
        )

    def _tangent_edges_apart(self, lines: Sequence[Lines], clip_from_points: Float64Array) -> list[tuple[Lines, ...]]:
        """Return the lines of each instance, silhouettes among them apart; none if there cannot be any."""
        tangent = self._source.tangent_edges(self._layer) if isinstance(self._source, MeshSource) else None
        if tangent is None or all(part.hidden is Hidden.SHOW for part in lines):
            return []
        among = self._on_device(tangent.key, tangent.find)
        n_edges = among.n_bytes // CANDIDATE.itemsize
        if n_edges == 0:
            return []
        planes = self._on_device(tangent.planes_key, tangent.planes)
        instances = []
        for matrix in clip_from_points:
            both = []
            for keeps_others in (True, False):
                edges = extract_silhouette(self._device, among, n_edges, planes, eye(matrix), keeps_others=keeps_others)
                self._stack.callback(edges.release)
                both.append((edges, not keeps_others))
            instances.append(
                tuple(replace(part, edges=edges, are_silhouettes=is_one) for part in lines for edges, is_one in both)
            )
        return instances

    def _chains(self, edges: EdgeSource) -> Buffer:
        """Return the chains of edges that are drawn in every view."""

        def pack() -> npt.NDArray[np.void]:
            return pack_chains(edges.find(), self._positions, max_batch_edges(self._device))

        return self._on_device(None if edges.key is None else ("chains", edges.key), pack)

    def _silhouette_chains(self, silhouette: Buffer, n_edges: int) -> Buffer:
        """Return the chains of the edges that are seen edge-on: others in each view, so the host must see them.

        On a coarse mesh they zigzag, towards the eye and away, which makes no corners in the picture.
        """
        with silhouette.map_read(EDGE_BYTES * n_edges) as view:
            edges = view.view(np.uint32).reshape(-1, 2).astype(np.int64)
        batch_size = max_batch_edges(self._device)
        return self._on_device(None, lambda: pack_chains(edges, self._positions, batch_size, max_turn_degrees=180.0))

    @property
    def _positions(self) -> Float64Array | None:
        mesh = self._source.mesh
        return None if mesh is None else mesh.positions

    def _faces(self, first_color: int, depth_cue: DepthCue) -> Faces | None:
        layer, source = self._layer, self._source
        if hidden_mode(layer) is Hidden.SHOW and layer.fill is None:
            return None
        triangles = self._on_device("triangles", lambda: source.triangles()[0].astype(np.uint32))
        n_triangles = triangles.n_bytes // TRIANGLE_BYTES
        if n_triangles == 0:
            return None
        color_indices = None
        if layer.fill is not None:
            color_indices = self._on_device("one colour", lambda: np.zeros(1, np.uint32))
            if len(fill_colors(layer, source.n_faces)) > 1 or layer.shading == "flat":
                color_indices = self._on_device("triangles' faces", lambda: source.triangles()[1].astype(np.uint32))
        is_opaque = layer.fill is not None and layer.alpha >= 1.0
        if is_opaque:
            is_opaque = bool((fill_colors(layer, source.n_faces)[:, 3] >= 1.0).all())
        normals = None
        if layer.fill is not None and layer.shading == "smooth" and source.mesh is not None:
            key = ("corner normals", layer.feature_angle) if source.mesh is source.owner else None
            normals = self._on_device(key, self._packed_normals)
        return Faces(
            triangles,
            n_triangles,
            color_indices,
            first_color,
            depth_cue,
            is_opaque=is_opaque,
            corner_normals=normals,
        )

    def _packed_normals(self) -> npt.NDArray[np.uint32]:
        """Return the normals at the corners of the triangles: (t, 3)."""
        source = self._source
        if source.mesh is None:
            return np.empty((0, 3), np.uint32)
        return pack_normals(triangle_normals(source.mesh, *source.triangles(), self._layer.feature_angle))

    def _on_device(self, key: Hashable | None, array: Callable[[], npt.NDArray[Any]]) -> Buffer:
        """Return the array on the device: kept from picture to picture if it has a key, else for this picture."""
        if key is not None:
            return self._device.resource_cache.get(self._source.owner, key, array)
        content = array()
        buffer = Buffer(self._device.context, max(content.nbytes, 4), label="draw list")
        self._stack.callback(buffer.release)
        if content.nbytes:
            buffer.upload(content)
        return buffer
