"""Colour palettes of GIF files: at most 255 colours, shared by all frames that they suit, without dithering."""

import math
from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ...imaging.image import Pixels

PaletteIndices: TypeAlias = npt.NDArray[np.uint8]
PackedColors: TypeAlias = npt.NDArray[np.uint32]

TRANSPARENT = 0  # the index of pixels that show what is below; colours have indices from 1
MAX_COLORS = 255
# What covers much of a picture keeps its colour exactly; the rest, the edges of lines, share the colours that are left.
MAX_EXACT_COLORS = 32
MAX_QUANTIZED_PIXELS = 1 << 12  # four times as many give 5 % better colours, and take three times as long
CELL_SIDE = 8  # the nearest colour is found once for all colours of a cell, of this side in red, green and blue
RGB_MASK = np.uint32(0xFFFFFF)  # the bits of a packed colour without alpha
HALF_OPAQUE = np.uint32(0x80000000)

# When a palette does not suit a frame. Anti-aliased edges of lines are off by up to 50, but few pixels of each colour:
# of solids turning in many colours, 1 pixel in 400 is off by more than COLOR_TOLERANCE in the same way. A background or
# a filled face that the palette lacks is many pixels of one colour; thin lines that it lacks are few pixels of each
# colour, but off by more than OUTLIER_TOLERANCE.
COLOR_TOLERANCE, OUTLIER_TOLERANCE = 8, 64  # in red, green or blue, of 255
FLAT_COLOR_TOLERANCE = 20  # in colour gradients, some pixels are off by more than COLOR_TOLERANCE
SIMILAR_RGB_MASK = np.uint32(0xF8F8F8)  # the bits that pixels of similar colours share
MAX_SIMILAR_SHARE, MAX_OUTLIER_SHARE = 1 / 128, 1 / 1024  # of the pixels compared
MAX_CHANCE_PIXELS = 4  # that may be similar by chance in a picture as small as a thumbnail
FLAT_ROW_STEP = 8  # every eighth row of pixels is searched for flat colours
MAX_COMPARED_PIXELS = 1 << 12  # of a frame, evenly spread: more take longer and find no more


class Palette:
    """At most 255 colours, chosen for the opaque pixels of `samples`, and the nearest of them to any colour."""

    def __init__(self, samples: Iterable[Pixels]) -> None:
        packed = _choose_colors(_count_colors(samples))
        self._colors = _unpack_rgb(packed)
        self._index_of = _nearest_indices(self._colors)
        self._index_of[packed[::-1]] = np.arange(len(packed), 0, -1)  # the chosen colours are exact
        self._color_of = np.append(np.uint32(0), packed)

    def table(self) -> bytes:
        """Return 256 colours of three bytes: black for transparent pixels, then the chosen ones."""
        return (bytes(3) + self._colors.tobytes()).ljust(3 * 256, b"\0")

    def indices(self, pixels: Pixels) -> PaletteIndices:
        """Return the index of each of the pixels' (height, width, 4) colours; 0 if it is less than half opaque."""
        packed = pack_pixels(pixels)
        indices: PaletteIndices = self._index_of.take(packed & RGB_MASK, mode="clip")  # skips the bounds check
        indices[packed < HALF_OPAQUE] = TRANSPARENT
        return indices

    def is_acceptable(self, pixels: Pixels, indices: PaletteIndices) -> bool:
        """Tell whether the colours of `indices` are near enough to those of the `pixels` (height, width, 4)."""
        step = math.isqrt(indices.size // MAX_COMPARED_PIXELS) + 1
        exact, compared = np.ascontiguousarray(pack_pixels(pixels)[::step, ::step]), indices[::step, ::step]
        a, b = exact.view(np.uint8), self._color_of.take(compared).view(np.uint8)
        differences = np.maximum(a, b) - np.minimum(a, b)
        is_visible = compared != TRANSPARENT
        if np.count_nonzero(_exceeds(differences, OUTLIER_TOLERANCE) & is_visible) > MAX_OUTLIER_SHARE * exact.size:
            return False
        off = exact[_exceeds(differences, COLOR_TOLERANCE) & is_visible]
        max_similar = max(MAX_CHANCE_PIXELS, MAX_SIMILAR_SHARE * exact.size)
        if len(off) > max_similar and np.unique(off & SIMILAR_RGB_MASK, return_counts=True)[1].max() > max_similar:
            return False
        return self._are_flat_colors_acceptable(pack_pixels(pixels), indices)

    def _are_flat_colors_acceptable(self, packed: PackedColors, indices: PaletteIndices) -> bool:
        """Tell whether blocks of 2 x 2 pixels of one colour, which edges are not, have nearly that colour."""
        upper, lower = packed[:-1:FLAT_ROW_STEP], packed[1::FLAT_ROW_STEP][: len(packed[:-1:FLAT_ROW_STEP])]
        compared = indices[:-1:FLAT_ROW_STEP, :-1]
        left = np.ascontiguousarray(upper[:, :-1])
        is_flat = (left == upper[:, 1:]) & (left == lower[:, :-1]) & (left == lower[:, 1:]) & (compared != TRANSPARENT)
        a, b = left.view(np.uint8), self._color_of.take(compared).view(np.uint8)
        is_off = _exceeds(np.maximum(a, b) - np.minimum(a, b), FLAT_COLOR_TOLERANCE)
        return int(np.count_nonzero(is_flat & is_off)) <= MAX_CHANCE_PIXELS


class Palettes:
    """The palette of a file, chosen for `samples`, and one for frames that it does not suit."""

    def __init__(self, samples: Iterable[Pixels]) -> None:
        self.common = Palette(samples)
        self._own: Palette | None = None

    def quantize(self, pixels: Pixels) -> tuple[Palette, PaletteIndices]:
        """Return a palette that suits the `pixels` (height, width, 4), the common one if it does, and their indices."""
        for palette in (self.common, self._own):
            if palette is not None:
                indices = palette.indices(pixels)
                if palette.is_acceptable(pixels, indices):
                    return palette, indices
        self._own = Palette([pixels])  # kept, because the following frames most likely have the same colours
        return self._own, self._own.indices(pixels)


def _exceeds(differences: npt.NDArray[np.uint8], tolerance: int) -> npt.NDArray[np.bool_]:
    """Tell which pixels, four bytes each, differ by more than `tolerance` in red, green or blue."""
    return np.asarray((differences > tolerance).view(np.uint32) & RGB_MASK != 0)


class _ColorCounts(NamedTuple):
    """The colours of opaque pixels: that of the first one, how many pixels have it, and those of the others (n,)."""

    first: np.uint32
    n_first: int
    others: PackedColors


def _count_colors(pictures: Iterable[Pixels]) -> _ColorCounts:
    first, n_opaque = None, 0
    others = []
    for pixels in pictures:
        packed = pack_pixels(pixels).reshape(-1)
        colors = packed[packed >= HALF_OPAQUE] & RGB_MASK
        n_opaque += len(colors)
        if first is None and len(colors):
            first = colors[0]
        # Most pixels are background, and most likely the first is: pixels that need not be sorted take no time.
        others.append(colors[colors != first])
    all_others = np.concatenate(others)
    return _ColorCounts(first or np.uint32(0), n_opaque - len(all_others), all_others)


def _choose_colors(sampled: _ColorCounts) -> PackedColors:
    """Return at most 255 colours: all that were sampled, or the most frequent and a median cut of the rest."""
    from PIL import Image

    others = sampled.others
    colors, counts = np.unique(others, return_counts=True)
    colors, counts = np.append(colors, sampled.first), np.append(counts, sampled.n_first)
    if len(colors) <= MAX_COLORS:
        return colors
    kept = colors[np.argsort(-counts, kind="stable")[:MAX_EXACT_COLORS]]
    rest = others[~np.isin(others, kept)]
    rest = rest[:: -(-len(rest) // MAX_QUANTIZED_PIXELS)]
    quantized = Image.fromarray(_unpack_rgb(rest)[np.newaxis], "RGB").quantize(
        MAX_COLORS - MAX_EXACT_COLORS,
        Image.Quantize.MEDIANCUT,
        kmeans=MAX_QUANTIZED_PIXELS // 100,  # it ends when fewer pixels change their colour
    )
    mixed = np.array(quantized.getpalette(), np.uint32).reshape(-1, 3)[: MAX_COLORS - MAX_EXACT_COLORS]
    return np.concatenate([kept, mixed @ np.array([1, 1 << 8, 1 << 16], np.uint32)])


def _nearest_indices(colors: npt.NDArray[np.uint8]) -> PaletteIndices:
    """Return, for every packed colour, the index of that of `colors` (k, 3) nearest to the centre of its cell."""
    centres = np.arange(CELL_SIDE / 2, 256, CELL_SIDE, dtype=np.float32)
    blue, green, red = np.meshgrid(centres, centres, centres, indexing="ij")
    cells = np.stack([red, green, blue], axis=-1).reshape(-1, 3)
    candidates = colors.astype(np.float32)
    # |a - b|^2 without |a|^2, which is the same for every b. A few cells at a time stay in the caches, and do not wake
    # the threads of a BLAS, which would keep spinning while frames are drawn.
    homogeneous = np.column_stack([cells, np.ones(len(cells), np.float32)])
    distances_from = np.vstack([-2.0 * candidates.T, (candidates**2).sum(axis=1)])
    parts = np.split(homogeneous, 4 * len(centres))
    nearest = np.concatenate([(part @ distances_from).argmin(axis=1) for part in parts])
    indices = (1 + nearest).astype(np.uint8).reshape(len(centres), 1, len(centres), 1, len(centres), 1)
    return indices.repeat(CELL_SIDE, axis=5).repeat(CELL_SIDE, axis=3).repeat(CELL_SIDE, axis=1).reshape(-1)


def pack_pixels(pixels: Pixels) -> PackedColors:
    """Return the `pixels` (..., 4) as one number each, alpha in the highest byte."""
    packed: PackedColors = np.ascontiguousarray(pixels).view("<u4")[..., 0]
    return packed


def _unpack_rgb(packed: PackedColors) -> npt.NDArray[np.uint8]:
    """Return packed colours (n,) as (n, 3)."""
    return np.ascontiguousarray(packed, "<u4").view(np.uint8).reshape(-1, 4)[:, :3]


def is_opaque(pixels: Pixels) -> npt.NDArray[np.bool_]:
    """Return which of `pixels` (..., 4) are at least half opaque."""
    return np.asarray(pack_pixels(pixels) >= HALF_OPAQUE)
