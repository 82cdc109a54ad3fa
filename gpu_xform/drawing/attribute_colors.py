"""Colours and scalars that a mesh holds as attributes, for styles that name them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from .._core.widen import widen
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from ..imaging.colormaps import apply_colormap

FILE = "file"
_TOLERANCE = 1e-3
AXES = ("x", "y", "z")


def find_scalars(mesh: Mesh, name: str) -> tuple[npt.NDArray[Any], bool]:
    """Return the attribute with one number per point or, failing that, per face, and whether it is per face.

    Without attributes of these names, "x", "y" and "z" are the coordinates of the points.

    Raises ArgumentError, which lists the names that there are.
    """
    tables = mesh.attributes.point, mesh.attributes.face
    for is_per_face, table in enumerate(tables):
        if name in table and _is_scalar(table[name]):
            return table[name], bool(is_per_face)
    if name in AXES:
        return mesh.positions[:, AXES.index(name)], False
    known = ", ".join(map(repr, list_scalars(mesh)))
    attributes = f", or an attribute with a number per point or face, {known}" if known else ", the model has no others"
    raise ArgumentError.expecting("scalars", f"be 'x', 'y' or 'z'{attributes}", repr(name))


def list_scalars(mesh: Mesh) -> list[str]:
    """Return the names of the attributes with one number per point or per face."""
    tables = mesh.attributes.point, mesh.attributes.face
    return list(dict.fromkeys(key for table in tables for key, column in table.items() if _is_scalar(column)))


def resolve_scalars(mesh: Mesh, name: str, cmap: Any, clim: Any) -> dict[str, Any]:
    """Return the style that shows the attribute `name`."""
    values, is_per_face = find_scalars(mesh, name)
    if not is_per_face:
        return {"scalars": values}
    return {"scalars": None, "face_colors": apply_colormap(values, cmap, clim, mesh.n_faces)}


def resolve_line_colors(mesh: Mesh) -> dict[str, Any]:
    """Return the style that draws lines and points in the colours of the file."""
    point = find_point_colors(mesh)
    if point is not None:
        return {"vertex_colors": point}
    face = find_face_colors(mesh)
    if face is not None:
        return {"face_colors": face}
    raise _no_colors("color")


def resolve_fill(mesh: Mesh) -> Float64Array:
    """Return a colour per face, from the file: (f, 4)."""
    face = find_face_colors(mesh)
    if face is not None:
        return face
    point = find_point_colors(mesh)
    if point is None:
        raise _no_colors("fill")
    return _average(point[mesh.indices], np.repeat(np.arange(mesh.n_faces), np.diff(mesh.offsets)), mesh.n_faces)


def find_point_colors(mesh: Mesh) -> Float64Array | None:
    """Return the colour of each point, or the mean of those at its corners: (n, 4)."""
    point = _as_rgba(mesh.attributes.point.get("color"))
    if point is not None:
        return point
    corner = _as_rgba(mesh.attributes.corner.get("color"))
    return None if corner is None else _average(corner, mesh.indices, mesh.n_points)


def find_face_colors(mesh: Mesh) -> Float64Array | None:
    """Return the colour of each face, or of its material: (f, 4)."""
    face = _as_rgba(mesh.attributes.face.get("color"))
    if face is not None or "material" not in mesh.attributes.face:
        return face
    names = mesh.attributes.labels.get("material", ())
    factors = [_find_base_color(mesh.attributes.material.get(name)) for name in names]
    if all(factor is None for factor in factors):
        return None
    table = np.array([(1.0, 1.0, 1.0, 1.0) if factor is None else factor for factor in (*factors, None)])
    numbers = np.asarray(mesh.attributes.face["material"])
    is_known = (numbers >= 0) & (numbers < len(names))
    return np.asarray(table[np.where(is_known, numbers, len(names))], np.float64)


def _find_base_color(material: Any) -> tuple[float, ...] | None:
    """Return the base colour of a glTF material; None if it has none."""
    if not isinstance(material, Mapping):
        return None
    surface = material.get("pbrMetallicRoughness")
    factor = surface.get("baseColorFactor") if isinstance(surface, Mapping) else None
    if not isinstance(factor, tuple | list) or len(factor) != 4:
        return None
    return tuple(map(float, factor)) if all(isinstance(part, int | float) for part in factor) else None


def _is_scalar(column: Any) -> bool:
    return isinstance(column, np.ndarray) and column.ndim == 1 and column.dtype.kind in "biuf"


def _as_rgba(column: Any) -> Float64Array | None:
    """Return colours as (n, 4) in 0..1; None for what are no colours."""
    if not isinstance(column, np.ndarray) or column.ndim != 2 or column.shape[1] not in (3, 4):
        return None
    largest = np.iinfo(column.dtype).max if column.dtype.kind in "iu" else 1.0
    if column.dtype.kind == "f":
        _require_fractions(column)
    colors = np.clip(widen(column) / largest, 0.0, 1.0)
    np.nan_to_num(colors, copy=False, nan=1.0)  # a point without a colour among others is white
    return colors if colors.shape[1] == 4 else np.column_stack([colors, np.ones(len(colors))])


def _require_fractions(colors: npt.NDArray[Any]) -> None:
    """Raise ArgumentError for colours that are not from 0 to 1, but for rounding and NaN."""
    wrong = colors[(colors > 1.0 + _TOLERANCE) | (colors < -_TOLERANCE)]
    if len(wrong):
        expected = "hold uint8, or floats from 0 to 1"
        raise ArgumentError.expecting("the attribute 'color' of the model", expected, f"{wrong[0]:g}")


def _average(colors: Float64Array, owners: npt.NDArray[np.int64], count: int) -> Float64Array:
    """Return the mean of the colours of each owner; one without any is black."""
    totals = np.stack([np.bincount(owners, colors[:, i], count) for i in range(4)], axis=1)
    n_colors = np.bincount(owners, minlength=count)
    means: Float64Array = totals / np.maximum(n_colors, 1)[:, np.newaxis]
    means[n_colors == 0] = (0.0, 0.0, 0.0, 1.0)
    return means


def _no_colors(argument: str) -> ArgumentError:
    return ArgumentError.expecting(
        argument, "be a colour", "'file'", reason="the model holds no attribute 'color' and no coloured material"
    )
