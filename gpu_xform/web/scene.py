"""A scene for a page: layers as data, where they stand in each frame, and the camera."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.error_context import prefix_errors
from .._core.types import Float64Array
from ..compute.mesh_buffer import MeshBuffer
from ..compute.point_buffer import PointBuffer
from ..drawing.camera import (
    DEFAULT_FOV_Y,
    DEFAULT_MARGIN,
    DEFAULT_UP,
    Camera,
    default_direction,
    extreme_points,
    upright,
)
from ..drawing.dash_patterns import as_dash_pattern
from ..drawing.framing import framing_points
from ..drawing.geometry_source import MeshSource, geometry_source
from ..drawing.intersections import MeetingLines
from ..drawing.layer import Layer, at_present, dot_diameter, with_lengths_in_pixels
from ..drawing.layer_colors import LineColors, fill_colors, line_colors
from ..drawing.lengths import PX_PER_INCH
from ..drawing.shading import pack_normals, triangle_normals
from ..errors import ArgumentError
from ..geometry.edges import is_single_array, list_edge_parts, resolve_edges, split_silhouette
from ..geometry.mesh import Mesh
from ..imaging.colors import pack_rgba8, to_rgba
from ..viewer.orbit import BoundingSphere, Orbit
from .arrays import ArrayStore
from .mesh_data import describe_mesh

FIT_ASPECTS = (0.3, 0.45, 0.6, 0.8, 1.0, 1.25, 1.6, 2.2, 3.3)  # of windows, from a phone's to a banner's

MAX_REACH = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Frames:
    """The matrices (n_frames, k, 4, 4) of each layer in turn, and how many frames are shown per second."""

    worlds: Sequence[Float64Array]
    fps: float

    @property
    def n_frames(self) -> int:
        """The number of frames."""
        return len(self.worlds[0])


def as_mesh_layer(layer: Layer) -> Layer:
    """Return a layer whose model is a mesh in the host's memory, and whose lengths are in pixels."""
    layer = with_lengths_in_pixels(at_present(layer), PX_PER_INCH)
    if isinstance(layer.model, MeshBuffer):
        return replace(layer, model=layer.model.mesh)
    if isinstance(layer.model, PointBuffer):
        return replace(layer, model=Mesh(layer.model.numpy()))
    source = geometry_source(layer)
    if source.mesh is None or source.mesh is layer.model:
        return layer
    return replace(layer, model=source.mesh, name=source.name)


def describe_layers(
    layers: Sequence[Layer], frames: Frames, line_widths: Sequence[float], store: ArrayStore
) -> dict[str, Any]:
    """Return the layers and their meshes for JSON; arrays go to `store`.

    line_widths : pixels, of the layers whose width is "auto" too
    """
    meshes: list[dict[str, Any]] = []
    numbers: dict[tuple[Any, ...], int] = {}
    described = []
    for i, (layer, width, worlds) in enumerate(zip(layers, line_widths, frames.worlds, strict=True)):
        with prefix_errors(layer.name or f"models[{i}]"):
            source = geometry_source(layer)
            if not isinstance(source, MeshSource):
                raise ArgumentError.expecting(
                    "models", "be meshes or points in memory for a page", type(source).__name__
                )
            key = (id(source.mesh), layer.feature_angle, *source.model_from_points.ravel().tolist())
            if key not in numbers:
                numbers[key] = len(meshes)
                meshes.append(describe_mesh(source, layer, store))
            flat = worlds.reshape(len(worlds), -1)
            is_still = bool((flat == flat[0]).all())
            described.append(
                {
                    **_describe_style(layer, source, width, store),
                    "mesh": numbers[key],
                    "matrices": store.add_floats(flat[:1] if is_still else flat),
                    "nInstances": worlds.shape[1],
                }
            )
    return {"meshes": meshes, "layers": described, "nFrames": frames.n_frames, "fps": frames.fps}


def _describe_style(layer: Layer, source: MeshSource, line_width: float, store: ArrayStore) -> dict[str, Any]:
    edges, own = _describe_edges(layer, source, store)
    hidden_style = layer.hidden_style
    return {
        "name": layer.name or "",
        "edges": edges,
        "ownEdges": own,
        "hidden": layer.hidden,
        "hiddenStyle": None if hidden_style is None else _describe_hidden_style(hidden_style),
        "lineWidth": line_width,
        "dash": list(as_dash_pattern(layer.dash, "dash")),
        "antialias": bool(layer.antialias),
        "colors": _describe_colors(layer, source, store),
        "fill": _describe_fill(layer, source, store),
        "shading": layer.shading,
        "cornerNormals": _describe_normals(layer, source, store),
        "isMeeting": isinstance(layer, MeetingLines),
        "alpha": float(layer.alpha),
        "depthCue": float(layer.depth_cue),
        "pointSize": dot_diameter(layer),
    }


def _describe_edges(layer: Layer, source: MeshSource, store: ArrayStore) -> tuple[dict[str, Any], int | None]:
    """Return which edges are drawn in every view, and whether silhouettes are; and edges that are given."""
    if layer.edges is None:
        return {"base": "all", "silhouette": False}, None
    rest, has_silhouette = split_silhouette(layer.edges)
    if rest is None:
        return {"base": None, "silhouette": has_silhouette}, None
    if isinstance(rest, str) and rest in ("all", "feature", "boundary"):
        return {"base": rest, "silhouette": has_silhouette}, None
    own = store.add_integers(resolve_edges(source.mesh, rest, layer.feature_angle))
    return {"base": "own", "silhouette": has_silhouette}, own


def _describe_hidden_style(style: Any) -> dict[str, Any]:
    described: dict[str, Any] = {"color": None, "lineWidth": None, "dash": None}
    if "color" in style:
        described["color"] = to_rgba(style["color"], "hidden_style")
    if "line_width" in style:
        described["lineWidth"] = float(style["line_width"])
    if "dash" in style:
        described["dash"] = list(as_dash_pattern(style["dash"], "hidden_style"))
    return described


def _describe_colors(layer: Layer, source: MeshSource, store: ArrayStore) -> dict[str, Any]:
    edge_source = source.edges(layer)
    colors: LineColors = line_colors(layer, source.n_points, source.n_faces, edge_source.n_colors)
    if colors.key == "cycle":
        return {"kind": "cycle"}
    if colors.mode.name == "UNIFORM":
        return {"kind": "one", "color": list(colors.uniform)}
    if colors.mode.name == "PER_VERTEX":
        return {"kind": "vertex", "values": store.add_integers(colors.packed)}
    if layer.face_colors is not None:
        return {"kind": "face", "values": store.add_integers(colors.packed)}
    packed = colors.packed
    is_own = layer.edges is not None and any(not isinstance(part, str) for part in list_edge_parts(layer.edges))
    if is_own and not is_single_array(layer.edges) and edge_source.color_rows:  # type: ignore[arg-type]
        packed = packed[edge_source.color_rows(edge_source.find())]
    return {"kind": "edge", "values": store.add_integers(packed)}


def _describe_fill(layer: Layer, source: MeshSource, store: ArrayStore) -> dict[str, Any] | None:
    if layer.fill is None:
        return None
    if isinstance(layer.fill, str) and layer.fill == "face":
        return {"kind": "cycle"}
    colors = fill_colors(layer, source.n_faces)
    if len(colors) == 1:
        return {"kind": "one", "color": colors[0].tolist()}
    return {"kind": "face", "values": store.add_integers(pack_rgba8(colors))}


def _describe_normals(layer: Layer, source: MeshSource, store: ArrayStore) -> int | None:
    """Return the normals at the corners of the triangles, which smooth shading takes."""
    if layer.shading != "smooth" or source.n_faces == 0:
        return None
    return store.add_integers(pack_normals(triangle_normals(source.mesh, *source.triangles(), layer.feature_angle)))


def describe_camera(
    camera: Camera | None,
    options: dict[str, Any],
    layers: Sequence[Layer],
    frames: Frames,
    aspect: float,
    store: ArrayStore,
) -> dict[str, Any]:
    """Return the first view, and the sphere around the models in all frames; arrays go to `store`.

    camera : None to fit one to windows of any aspect, by `options`
    """
    extremes = [np.empty((0, 3))]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for k in range(frames.n_frames):
        moved = [replace(layer, transform=worlds[k]) for layer, worlds in zip(layers, frames.worlds, strict=True)]
        points = framing_points(moved)
        if len(points):
            low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
        if camera is None:
            extremes += [extreme_points(points, each, **options) for each in (*FIT_ASPECTS, aspect)]
    reach = float(np.max(0.5 * high - 0.5 * low, initial=0.0))
    if np.isfinite(reach) and reach > MAX_REACH:
        expected = f"reach at most {MAX_REACH:g} from their centre, the largest number of a browser's shaders"
        raise ArgumentError.expecting("models", expected, f"{reach:g}")
    bounds = BoundingSphere.around(np.stack([low, high]) if np.isfinite(low).all() else np.empty((0, 3)))
    described: dict[str, Any] = {"bounds": {"center": bounds.center.tolist(), "radius": bounds.radius}}
    if camera is None:
        points = np.unique(np.concatenate(extremes), axis=0)
        first = Orbit.from_camera(Camera.fit(points, **options), aspect, bounds)
        described["fit"] = _describe_options(options)
        offsets = (points - bounds.center).astype(np.float32)  # whose bytes are half zero
        described["points"] = store.add_floats(offsets.astype(np.float64))
    else:
        first = Orbit.from_camera(camera, aspect, bounds)
    described["orbit"] = {"up": first.up.tolist()}
    if camera is not None:
        described["orbit"] |= {
            "target": first.target.tolist(),
            "distance": first.distance,
            "axes": first.axes.tolist(),
            "fovY": first.fov_y,
            "isParallel": first.orthographic,
            "shift": first.shift.tolist(),
        }
    return described


def _describe_options(options: dict[str, Any]) -> dict[str, Any]:
    up = np.asarray(options.get("up", DEFAULT_UP), np.float64)
    along = options.get("direction")
    direction: npt.NDArray[Any] = default_direction(up) if along is None else np.asarray(along, np.float64)
    return {
        "direction": (direction / np.linalg.norm(direction)).tolist(),
        "up": upright(direction, up).tolist(),
        "margin": float(options.get("margin", DEFAULT_MARGIN)),
        "fovY": float(options.get("fov_y", DEFAULT_FOV_Y)),
        "isParallel": bool(options.get("orthographic", False)),
    }
