"""The colours of a GIF: at most 255 for all of its frames, and none mixed from dots."""

import numpy as np
import numpy.typing as npt

from ...images import Pixels

Indices = npt.NDArray[np.uint8]
Codes = npt.NDArray[np.uint32]

TRANSPARENT = 0  # the number of pixels that let through what is below; colours are numbered from 1
MOST_COLORS = 255
# What covers much of a picture keeps its colour to the last bit; the rest, the rims of lines, shares what is left.
MOST_KEPT = 32
MOST_PIXELS = 1 << 12  # a choice among four times as many is a twentieth better, and takes three times as long
CELL = 8  # the nearest colour is looked for once for all colours that differ by less


class Palette:
    """At most 255 colours, chosen for the opaque pixels of `samples` (..., 4), and which of them stands for another."""

    def __init__(self, samples: npt.NDArray[np.uint8]) -> None:
        opaque = is_opaque(samples)
        self.is_opaque = bool(opaque.all())
        chosen = _chosen(codes(samples)[opaque])
        self._colors = _rgb(chosen)
        self._number_of = _numbers(self._colors)
        self._number_of[chosen[::-1]] = np.arange(len(chosen), 0, -1)  # what was chosen is exact

    def table(self) -> bytes:
        """Return 256 colours of three bytes: black for what is transparent, then the chosen ones."""
        return (bytes(3) + self._colors.tobytes()).ljust(3 * 256, b"\0")

    def indices(self, pixels: Pixels) -> Indices:
        """Return for each of the pixels (height, width, 4) its colour's number; 0 where it is less than half opaque."""
        indices = self._number_of[codes(pixels)]
        indices[~is_opaque(pixels)] = TRANSPARENT
        return indices


def _chosen(codes: Codes) -> Codes:
    """Return at most 255 colours for pixels of the colours `codes` (n,)."""
    from PIL import Image

    if len(codes) == 0:
        return np.zeros(1, np.uint32)
    # Most pixels are background, and so, most likely, is the first: what need not be sorted takes no time.
    others = codes[codes != codes[0]]
    colors, counts = np.unique(others, return_counts=True)
    colors, counts = np.append(colors, codes[0]), np.append(counts, len(codes) - len(others))
    if len(colors) <= MOST_COLORS:
        return colors
    kept = colors[np.argsort(-counts, kind="stable")[:MOST_KEPT]]
    rest = others[~np.isin(others, kept)]
    rest = rest[:: -(-len(rest) // MOST_PIXELS)]
    quantized = Image.fromarray(_rgb(rest)[np.newaxis], "RGB").quantize(
        MOST_COLORS - MOST_KEPT,
        Image.Quantize.MEDIANCUT,
        kmeans=MOST_PIXELS // 100,  # who still change when it ends
    )
    mixed = np.array(quantized.getpalette(), np.uint32).reshape(-1, 3)[: MOST_COLORS - MOST_KEPT]
    return np.concatenate([kept, mixed @ np.array([1, 1 << 8, 1 << 16], np.uint32)])


def _numbers(colors: npt.NDArray[np.uint8]) -> Indices:
    """Return for every code the number of that of `colors` (k, 3) which is nearest to the middle of its cell."""
    middles = np.arange(CELL / 2, 256, CELL, dtype=np.float32)
    blue, green, red = np.meshgrid(middles, middles, middles, indexing="ij")
    cells = np.stack([red, green, blue], axis=-1).reshape(-1, 3)
    chosen = colors.astype(np.float32)
    # |a - b|^2 without |a|^2, which is the same for every b. So few cells at once stay in the caches, and do not wake
    # the threads of a BLAS, which would spin on while frames are drawn.
    homogeneous = np.column_stack([cells, np.ones(len(cells), np.float32)])
    distances_from = np.vstack([-2.0 * chosen.T, (chosen**2).sum(axis=1)])
    parts = np.split(homogeneous, 4 * len(middles))
    nearest = np.concatenate([(part @ distances_from).argmin(axis=1) for part in parts])
    numbers = (1 + nearest).astype(np.uint8).reshape(len(middles), 1, len(middles), 1, len(middles), 1)
    return numbers.repeat(CELL, axis=5).repeat(CELL, axis=3).repeat(CELL, axis=1).reshape(-1)


def codes(pixels: npt.NDArray[np.uint8]) -> Codes:
    """Return the colours of `pixels` (..., 4) as one number each, red in the lowest byte."""
    return words(pixels) & np.uint32(0xFFFFFF)


def words(pixels: npt.NDArray[np.uint8]) -> Codes:
    """Return the `pixels` (..., 4) as one number each, opacity in the highest byte."""
    packed: Codes = np.ascontiguousarray(pixels).view("<u4")[..., 0]
    return packed


def _rgb(codes: Codes) -> npt.NDArray[np.uint8]:
    """Return `codes` (n,) as colours (n, 3)."""
    return np.ascontiguousarray(codes, "<u4").view(np.uint8).reshape(-1, 4)[:, :3]


def is_opaque(pixels: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    """Return which of `pixels` (..., 4) are more than half opaque."""
    return np.asarray(pixels[..., 3] >= 128)
