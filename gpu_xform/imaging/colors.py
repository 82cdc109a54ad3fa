"""Colours as people write them, one or one a row, and the cycle that tells faces apart."""

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_real_array
from .._core.types import Float64Array
from ..errors import ArgumentError

FloatColor: TypeAlias = tuple[float, float, float, float]
OneColor: TypeAlias = str | Sequence[float] | npt.NDArray[np.floating[Any]]
ColorLike: TypeAlias = OneColor | tuple[OneColor, float]
ColorRows: TypeAlias = npt.ArrayLike | Iterable[ColorLike]

# Ten hues that stay apart for most eyes: the category10 palette of Tableau, which matplotlib cycles through as well.
FACE_CYCLE = (
    "#1f77b4",
    "#ff7f0e",
    "#2ca02c",
    "#d62728",
    "#9467bd",
    "#8c564b",
    "#e377c2",
    "#7f7f7f",
    "#bcbd22",
    "#17becf",
)
_TABLEAU = ("blue", "orange", "green", "red", "purple", "brown", "pink", "gray", "olive", "cyan")

# What Pillow lacks of matplotlib's names. Its letters are darker than the names they stand for: "g" is not "lime".
_MATPLOTLIB: dict[str, FloatColor | str] = {
    "none": (0.0, 0.0, 0.0, 0.0),
    "b": (0.0, 0.0, 1.0, 1.0),
    "g": (0.0, 0.5, 0.0, 1.0),
    "r": (1.0, 0.0, 0.0, 1.0),
    "c": (0.0, 0.75, 0.75, 1.0),
    "m": (0.75, 0.0, 0.75, 1.0),
    "y": (0.75, 0.75, 0.0, 1.0),
    "k": (0.0, 0.0, 0.0, 1.0),
    "w": (1.0, 1.0, 1.0, 1.0),
    "tab:grey": "#7f7f7f",
    **{f"tab:{name}": hue for name, hue in zip(_TABLEAU, FACE_CYCLE, strict=True)},
}


def rgba(color: ColorLike, name: str) -> FloatColor:
    """Return red, green, blue and alpha in [0, 1], straight.

    color : as Pillow and matplotlib write them: a name of CSS, "#rgb", "#rgba", "#rrggbb", "#rrggbbaa", "rgb(...)",
        "hsl(...)", "k", "C0", "tab:blue", a grey from "0" to "1", or "none", which is transparent; three or four
        numbers in [0, 1]; or a tuple of one of these and an alpha
    """
    if isinstance(color, str):
        try:
            return _named(color.strip())
        except ValueError:
            raise ArgumentError.expecting(name, "be a colour's name or #rrggbb", repr(color)) from None
    if isinstance(color, tuple) and len(color) == 2 and isinstance(color[0], str | Sequence | np.ndarray):
        return _with_alpha(color[0], color[1], name)
    components = as_real_array(color, name)
    if components.shape not in {(3,), (4,)} or (components < 0).any() or (components > 1).any():
        raise ArgumentError.expecting(name, "be a colour's name, or three or four numbers from 0 to 1", repr(color))
    red, green, blue, *rest = components.tolist()
    return red, green, blue, rest[0] if rest else 1.0


def backdrop(background: ColorLike | None) -> FloatColor:
    """Return the colour behind a picture; None is transparent."""
    return (0.0, 0.0, 0.0, 0.0) if background is None else rgba(background, "background")


def color_rows(values: ColorRows, name: str, n_rows: int, of: str) -> Float64Array:
    """Return a colour for each of `n_rows` things: (n_rows, 4) float64 in [0, 1], straight.

    values : (n_rows, 3) or (n_rows, 4), in [0, 1] or, as uint8, from 0 to 255; or n_rows colours as `rgba` takes them
    of : what has these colours, in the plural: "faces"

    Raises `ArgumentError` that names the argument: "face_colors must have one row for each of the 12 faces, got 11".
    """
    if isinstance(values, str):
        raise ArgumentError.expecting(name, f"be one colour for each of the {n_rows} {of}", f"the one {values!r}")
    try:
        array = np.asarray(values)
    except ValueError:  # of several lengths: names, numbers and pairs together
        array = np.empty((), np.object_)
    if array.dtype.kind in "OU" and np.iterable(values):
        one_by_one: Iterable[Any] = values
        array = np.array([rgba(value, f"{name}[{i}]") for i, value in enumerate(one_by_one)]).reshape(-1, 4)
    is_octets = array.dtype == np.uint8
    colors = as_real_array(array, name)
    if is_octets:
        colors /= 255
    if colors.ndim != 2 or colors.shape[1] not in (3, 4):
        raise ArgumentError.expecting(name, f"have shape ({n_rows}, 3) or ({n_rows}, 4)", colors.shape)
    if len(colors) != n_rows:
        raise ArgumentError.expecting(name, f"have one row for each of the {n_rows} {of}", len(colors))
    outside = (colors < 0) | (colors > 1)
    if outside.any():
        row, column = np.argwhere(outside)[0].tolist()
        raise ArgumentError.expecting(
            name, "hold numbers from 0 to 1, or uint8", f"{colors[row, column]:g} at index ({row}, {column})"
        )
    return colors if colors.shape[1] == 4 else np.column_stack([colors, np.ones(n_rows)])


def packed(colors: Sequence[FloatColor] | Float64Array) -> npt.NDArray[np.uint32]:
    """Return each colour as WGSL's `unpack4x8unorm` takes it, red in the lowest byte: (k,) uint32."""
    octets = np.rint(np.array(colors) * 255).astype(np.uint8)
    return np.ascontiguousarray(octets).view("<u4").reshape(-1)


def _with_alpha(color: OneColor, alpha: float, name: str) -> FloatColor:
    opacity = as_float(alpha, f"the alpha of {name}")
    if not 0.0 <= opacity <= 1.0:
        raise ArgumentError.expecting(f"the alpha of {name}", "be from 0 to 1", f"{opacity:g}")
    red, green, blue, _ = rgba(color, name)
    is_none = isinstance(color, str) and color.strip().lower() == "none"
    return red, green, blue, 0.0 if is_none else opacity


@lru_cache
def _named(color: str) -> FloatColor:
    """Read what stands in `color`; raise `ValueError` where that is no colour."""
    from PIL import ImageColor

    if re.fullmatch("C[0-9]+", color):
        return _named(FACE_CYCLE[int(color[1:]) % len(FACE_CYCLE)])
    known = _MATPLOTLIB.get(color if len(color) == 1 else color.lower())
    if known is not None:
        return _named(known) if isinstance(known, str) else known
    if re.fullmatch(r"[0-9.]+(e-[0-9]+)?", color):
        grey = float(color)
        if grey > 1.0:
            raise ValueError
        return grey, grey, grey, 1.0
    if color.lower().startswith("rgba"):  # Pillow counts this alpha to 255, CSS to 1: one reading's opaque is invisible
        raise ValueError
    octets: tuple[int, ...] = ImageColor.getcolor(color, "RGBA")  # type: ignore[assignment]
    if min(octets) < 0 or max(octets) > 255:  # Pillow lets rgb(300, 0, 0) pass
        raise ValueError
    red, green, blue, alpha = (octet / 255 for octet in octets)
    return red, green, blue, alpha
