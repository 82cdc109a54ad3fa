"""Colours: parsing of one colour or of one per row, packing, and the colour cycle."""

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_real_array
from .._core.masked import require_whole
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError

Rgba: TypeAlias = tuple[float, float, float, float]
PlainColor: TypeAlias = str | Sequence[float] | npt.NDArray[np.floating[Any]]
ColorLike: TypeAlias = PlainColor | tuple[PlainColor, float]
ColorRows: TypeAlias = npt.ArrayLike | Iterable[ColorLike]

# Tableau's category10 palette, which is matplotlib's default cycle: ten hues that most people can tell apart.
COLOR_CYCLE = (
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
_TABLEAU_NAMES = ("blue", "orange", "green", "red", "purple", "brown", "pink", "gray", "olive", "cyan")

# Names of matplotlib that Pillow does not know. Single letters are darker than the CSS names: "g" is not "lime". The
# first two Pillow knows too: a picture without other colours need not import it.
_MATPLOTLIB_COLORS: dict[str, Rgba | str] = {
    "black": (0.0, 0.0, 0.0, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
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
    **{f"tab:{name}": hue for name, hue in zip(_TABLEAU_NAMES, COLOR_CYCLE, strict=True)},
}


def to_rgba(color: ColorLike, name: str) -> Rgba:
    """Return red, green, blue and alpha in [0, 1], straight.

    color : a text as in Pillow and matplotlib: a CSS name, "#rgb", "#rgba", "#rrggbb", "#rrggbbaa", "rgb(...)",
        "hsl(...)", "k", "C0", "tab:blue", a grey from "0" to "1", or "none", which is transparent; or three or four
        numbers in [0, 1]; or a tuple of one of these and an alpha
    """
    if isinstance(color, str):
        try:
            return _parse_color_text(color.strip())
        except ValueError:
            hint = did_you_mean(color.strip().lower(), _list_color_names())
            raise ArgumentError.expecting(name, "be a colour's name or #rrggbb", f"{color!r}{hint}") from None
    if isinstance(color, tuple) and len(color) == 2 and isinstance(color[0], str | Sequence | np.ndarray):
        return _replace_alpha(color[0], color[1], name)
    components = as_real_array(color, name)
    if components.shape not in {(3,), (4,)} or (components < 0).any() or (components > 1).any():
        raise ArgumentError.expecting(name, "be a colour's name, or three or four numbers from 0 to 1", repr(color))
    red, green, blue, *rest = components.tolist()
    return red, green, blue, rest[0] if rest else 1.0


def _list_color_names() -> list[str]:
    from PIL import ImageColor

    return list(ImageColor.colormap)


def parse_background(background: ColorLike | None) -> Rgba:
    """Return the background colour; None is transparent."""
    return (0.0, 0.0, 0.0, 0.0) if background is None else to_rgba(background, "background")


def to_rgba_array(values: ColorRows, name: str, n_rows: int, of: str) -> Float64Array:
    """Return one colour per row: (n_rows, 4) float64 in [0, 1], straight.

    values : (n_rows, 3) or (n_rows, 4), in [0, 1] or, as uint8, from 0 to 255; or n_rows colours as for `to_rgba`
    of : the plural of what has these colours, for messages: "faces"

    Raises ArgumentError, such as "face_colors must have one row for each of the 12 faces, got 11".
    """
    if isinstance(values, str):
        raise ArgumentError.expecting(name, f"be one colour for each of the {n_rows} {of}", f"the one {values!r}")
    require_whole(values, name)
    try:
        array = np.asarray(values)
    except ValueError:  # rows of several lengths: names, numbers and pairs mixed
        array = np.empty((), np.object_)
    if array.dtype.kind in "OU" and np.iterable(values):
        one_by_one: Iterable[Any] = values
        array = np.array([to_rgba(value, f"{name}[{i}]") for i, value in enumerate(one_by_one)]).reshape(-1, 4)
    is_uint8 = array.dtype == np.uint8
    colors = as_real_array(array, name)
    if is_uint8:
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


def pack_rgba8(colors: Sequence[Rgba] | Float64Array) -> npt.NDArray[np.uint32]:
    """Return colours (k, 4) as WGSL's `unpack4x8unorm` takes them, red in the lowest byte: (k,) uint32."""
    channels = np.rint(np.array(colors) * 255).astype(np.uint8)
    return np.ascontiguousarray(channels).view("<u4").reshape(-1)


def _replace_alpha(color: PlainColor, alpha: float, name: str) -> Rgba:
    opacity = as_float(alpha, f"the alpha of {name}")
    if not 0.0 <= opacity <= 1.0:
        raise ArgumentError.expecting(f"the alpha of {name}", "be from 0 to 1", f"{opacity:g}")
    red, green, blue, _ = to_rgba(color, name)
    is_none = isinstance(color, str) and color.strip().lower() == "none"
    return red, green, blue, 0.0 if is_none else opacity


@lru_cache
def _parse_color_text(color: str) -> Rgba:
    """Return the colour that a text names; raise ValueError for any other text."""
    if re.fullmatch("C[0-9]+", color):
        return _parse_color_text(COLOR_CYCLE[int(color[1:]) % len(COLOR_CYCLE)])
    known = _MATPLOTLIB_COLORS.get(color if len(color) == 1 else color.lower())
    if known is not None:
        return _parse_color_text(known) if isinstance(known, str) else known
    if re.fullmatch(r"[0-9.]+(e-[0-9]+)?", color):
        grey = float(color)
        if grey > 1.0:
            raise ValueError
        return grey, grey, grey, 1.0
    if color.lower().startswith("rgba"):  # ambiguous: alpha goes to 255 in Pillow and to 1 in CSS
        raise ValueError
    from PIL import ImageColor

    channels: tuple[int, ...] = ImageColor.getcolor(color, "RGBA")  # type: ignore[assignment]
    if min(channels) < 0 or max(channels) > 255:  # Pillow accepts rgb(300, 0, 0)
        raise ValueError
    red, green, blue, alpha = (channel / 255 for channel in channels)
    return red, green, blue, alpha
