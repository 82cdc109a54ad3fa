"""The colours of a GIF: at most 255 for all frames that they suit, and none mixed from dots."""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...imaging.image import Pixels

Indices = npt.NDArray[np.uint8]
Codes = npt.NDArray[np.uint32]

TRANSPARENT = 0  # the number of pixels that let through what is below; colours are numbered from 1
MOST_COLORS = 255
# What covers much of a picture keeps its colour to the last bit; the rest, the rims of lines, shares what is left.
MOST_KEPT = 32
MOST_PIXELS = 1 << 12  # a choice among four times as many is a twentieth better, and takes three times as long
CELL = 8  # the nearest colour is looked for once for all colours that differ by less
COLOR = np.uint32(0xFFFFFF)  # the bits of a pixel's colour
HALF_OPAQUE = np.uint32(0x80000000)

# What a palette does not suit. The rims of lines are off by up to 50, but few pixels of each colour: of solids turning
# in many colours, 1 in 400 is off by more than NEAR in the same way. A ground or a painted face that the palette does
# not hold is many pixels of one colour; thin lines that it does not hold are few of each, but FAR off.
NEAR, FAR = 8, 64  # in red, green or blue
NEAR_WHERE_FLAT = 20  # of colours that go over into one another, some are off by more than NEAR
ALIKE = np.uint32(0xF8F8F8)  # the bits that pixels of about one colour share
MOST_ALIKE, MOST_FAR = 1 / 128, 1 / 1024
FEW = 4  # pixels, which may be alike by chance in a picture as small as a thumbnail
FLAT_ROWS = 8  # from one row of pixels to the next that is looked through for flat colours, of any number of pixels
MOST_COMPARED = 1 << 12  # pixels of a frame, evenly spread: to compare more takes longer and tells no more


class Palette:
    """At most 255 colours, chosen for the opaque pixels of `samples`, and which of them stands for another."""

    def __init__(self, samples: Iterable[Pixels]) -> None:
        chosen = _chosen(_sampled(samples))
        self._colors = _rgb(chosen)
        self._number_of = _numbers(self._colors)
        self._number_of[chosen[::-1]] = np.arange(len(chosen), 0, -1)  # what was chosen is exact
        self._code_of = np.append(np.uint32(0), chosen)

    def table(self) -> bytes:
        """Return 256 colours of three bytes: black for what is transparent, then the chosen ones."""
        return (bytes(3) + self._colors.tobytes()).ljust(3 * 256, b"\0")

    def indices(self, pixels: Pixels) -> Indices:
        """Return for each of the pixels (height, width, 4) its colour's number; 0 where it is less than half opaque."""
        packed = words(pixels)
        indices: Indices = self._number_of.take(packed & COLOR, mode="clip")  # without a check of each
        indices[packed < HALF_OPAQUE] = TRANSPARENT
        return indices

    def suits(self, pixels: Pixels, indices: Indices) -> bool:
        """Say whether the `pixels` (height, width, 4) are near enough to the colours that `indices` show them in."""
        step = math.isqrt(indices.size // MOST_COMPARED) + 1
        compared, numbers = np.ascontiguousarray(words(pixels)[::step, ::step]), indices[::step, ::step]
        shown = self._code_of.take(numbers)
        a, b = compared.view(np.uint8), shown.view(np.uint8)
        differences = np.maximum(a, b) - np.minimum(a, b)
        is_seen = numbers != TRANSPARENT
        if np.count_nonzero(_exceeds(differences, FAR) & is_seen) > MOST_FAR * compared.size:
            return False
        off = compared[_exceeds(differences, NEAR) & is_seen]
        most = max(FEW, MOST_ALIKE * compared.size)
        if len(off) > most and np.unique(off & ALIKE, return_counts=True)[1].max() > most:
            return False
        return self._shows_what_is_flat(words(pixels), indices)

    def _shows_what_is_flat(self, packed: Codes, indices: Indices) -> bool:
        """Say whether what is of one colour for two pixels each way, as rims are not, is shown in nearly that."""
        upper, lower = packed[:-1:FLAT_ROWS], packed[1::FLAT_ROWS][: len(packed[:-1:FLAT_ROWS])]
        numbers = indices[:-1:FLAT_ROWS, :-1]
        left = np.ascontiguousarray(upper[:, :-1])
        is_flat = (left == upper[:, 1:]) & (left == lower[:, :-1]) & (left == lower[:, 1:]) & (numbers != TRANSPARENT)
        a, b = left.view(np.uint8), self._code_of.take(numbers).view(np.uint8)
        is_off = _exceeds(np.maximum(a, b) - np.minimum(a, b), NEAR_WHERE_FLAT)
        return int(np.count_nonzero(is_flat & is_off)) <= FEW


class Palettes:
    """The palette of a file, chosen for `samples`, and one for frames that it does not suit."""

    def __init__(self, samples: Iterable[Pixels]) -> None:
        self.common = Palette(samples)
        self._own: Palette | None = None

    def indexed(self, pixels: Pixels) -> tuple[Palette, Indices]:
        """Return a palette that suits the `pixels` (height, width, 4), the common one if it does, and their indices."""
        for palette in (self.common, self._own):
            if palette is not None:
                indices = palette.indices(pixels)
                if palette.suits(pixels, indices):
                    return palette, indices
        self._own = Palette([pixels])  # kept, for the frames that follow are most likely of the same colours
        return self._own, self._own.indices(pixels)


def _exceeds(differences: npt.NDArray[np.uint8], least: int) -> npt.NDArray[np.bool_]:
    """Return where one of a pixel's colours, four bytes with opacity, differs by more than `least`."""
    return np.asarray((differences > least).view(np.uint32) & COLOR != 0)


class _Sampled(NamedTuple):
    """The colours of opaque pixels: the first one's, of how many it is the colour, and those of the others (n,)."""

    first: np.uint32
    n_first: int
    others: Codes


def _sampled(pictures: Iterable[Pixels]) -> _Sampled:
    first, n_opaque = None, 0
    others = []
    for pixels in pictures:
        packed = words(pixels).reshape(-1)
        colors = packed[packed >= HALF_OPAQUE] & COLOR
        n_opaque += len(colors)
        if first is None and len(colors):
            first = colors[0]
        # Most pixels are background, and so, most likely, is the first: what need not be sorted takes no time.
        others.append(colors[colors != first])
    together = np.concatenate(others)
    return _Sampled(first or np.uint32(0), n_opaque - len(together), together)


def _chosen(sampled: _Sampled) -> Codes:
    """Return at most 255 colours for what was sampled."""
    from PIL import Image

    others = sampled.others
    colors, counts = np.unique(others, return_counts=True)
    colors, counts = np.append(colors, sampled.first), np.append(counts, sampled.n_first)
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


def words(pixels: Pixels) -> Codes:
    """Return the `pixels` (..., 4) as one number each, opacity in the highest byte."""
    packed: Codes = np.ascontiguousarray(pixels).view("<u4")[..., 0]
    return packed


def _rgb(codes: Codes) -> npt.NDArray[np.uint8]:
    """Return `codes` (n,) as colours (n, 3)."""
    return np.ascontiguousarray(codes, "<u4").view(np.uint8).reshape(-1, 4)[:, :3]


def is_opaque(pixels: Pixels) -> npt.NDArray[np.bool_]:
    """Return which of `pixels` (..., 4) are more than half opaque."""
    return np.asarray(words(pixels) >= HALF_OPAQUE)
