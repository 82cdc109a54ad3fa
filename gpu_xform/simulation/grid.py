"""Regular grids: points in rows and columns with the same springs everywhere, as in cloth and in equal strands."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..gpu.layouts import GRID_SPRINGS
from .incidence import Slots, SpringSlots

COLUMNS_PER_BLOCK = 4
MIN_COLUMNS = 8
MIN_POINTS = 1024  # of fewer, copying to blocks and back takes longer than is won

KINDS = {(0, 1): "along_row", (0, 2): "over_row", (1, 0): "along_column", (2, 0): "over_column"}
SHEAR = {(1, 1), (1, -1)}


@dataclass(frozen=True, eq=False)
class Grid:
    """n_rows x n_columns points, of which point (i, j) has the index i row_shift + j column_shift.

    springs : by kind, the stiffness and the stiffness times the rest length
    max_rows_per_strip : how many rows an invocation goes down at most; two rows above each strip are computed in vain
    """

    n_rows: int
    n_columns: int
    row_shift: int
    column_shift: int
    springs: dict[str, tuple[float, float]]
    max_rows_per_strip: int

    @property
    def has_rows(self) -> bool:
        """Whether there are springs between columns."""
        return any(name not in ("along_column", "over_column") for name in self.springs)

    @property
    def n_blocks(self) -> int:
        """How many blocks of four columns a row has."""
        return -(-self.n_columns // COLUMNS_PER_BLOCK)

    @property
    def rows_per_strip(self) -> int:
        """How many rows an invocation goes down."""
        n_strips = -(-self.n_rows // self.max_rows_per_strip)
        return -(-self.n_rows // n_strips)

    @property
    def n_strips(self) -> int:
        """How many strips of rows there are."""
        return -(-self.n_rows // self.rows_per_strip)

    @property
    def padded_shape(self) -> tuple[int, int]:
        """Blocks and rows, with an empty block at either end of a row, and two empty rows."""
        return self.n_blocks + 2, self.n_strips * self.rows_per_strip + 4

    def to_blocks(self, values: Float64Array) -> npt.NDArray[np.float32]:
        """Return a number per point (n,) as blocks of four columns, row by row: `padded_shape` and 4."""
        n_padded_blocks, n_padded_rows = self.padded_shape
        rows = np.zeros((n_padded_rows, n_padded_blocks * COLUMNS_PER_BLOCK), np.float32)
        index = np.add.outer(np.arange(self.n_rows) * self.row_shift, np.arange(self.n_columns) * self.column_shift)
        rows[2 : 2 + self.n_rows, COLUMNS_PER_BLOCK : COLUMNS_PER_BLOCK + self.n_columns] = values[index]
        return np.ascontiguousarray(rows.reshape(n_padded_rows, n_padded_blocks, -1).swapaxes(0, 1))

    def struct(self) -> npt.NDArray[np.void]:
        """Return `layouts.GRID_SPRINGS`."""
        struct = np.zeros((), GRID_SPRINGS)
        for name, spring in self.springs.items():
            struct[name] = spring
        struct["height"], struct["width"] = self.n_rows, self.n_columns
        struct["row_shift"], struct["column_shift"] = self.row_shift, self.column_shift
        struct["n_blocks"], struct["n_strips"] = self.n_blocks, self.n_strips
        struct["n_padded_rows"] = self.padded_shape[1]
        return struct


def find_grid(slots: SpringSlots, n_points: int, max_rows_per_strip: int) -> Grid | None:
    """Return the grid that springs in slots make of their points; None if they make none."""
    if slots.kind is not Slots.SHIFTED or n_points < MIN_POINTS:
        return None
    used = slots.packets["stiffness"].ravel() > 0.0
    shifts = slots.packets["shift"].ravel()[used].astype(int).tolist()
    rest, stiffness = slots.packets["rest"].ravel()[used], slots.packets["stiffness"].ravel()[used]
    if len(set(shifts)) != len(shifts):
        return None
    constants = {shift: (float(k), float(k) * float(r)) for shift, k, r in zip(shifts, stiffness, rest, strict=True)}
    bits = dict(zip(shifts, np.flatnonzero(used).tolist(), strict=True))
    for grid_shape in _list_shapes(slots, bits, n_points):
        springs = _match(grid_shape, slots, constants, bits)
        if springs is not None:
            return Grid(*grid_shape, springs, max_rows_per_strip)
    return None


def _list_shapes(slots: SpringSlots, bits: dict[int, int], n_points: int) -> Iterator[tuple[int, int, int, int]]:
    """Yield the numbers of rows and columns, and their shifts, that are worth a try."""
    if set(bits) <= {1, -1, 2, -2} and 1 in bits:  # strands one after another
        ends = np.flatnonzero((slots.masks >> np.uint32(bits[1])) & np.uint32(1) == 0)
        n_rows = int(ends[0]) + 1
        if n_points % n_rows == 0:
            yield n_rows, n_points // n_rows, 1, n_rows
    for n_columns in sorted(shift for shift in bits if shift >= MIN_COLUMNS):
        if n_points % n_columns == 0:
            yield n_points // n_columns, n_columns, n_columns, 1


def _match(
    shape: tuple[int, int, int, int],
    slots: SpringSlots,
    constants: dict[int, tuple[float, float]],
    bits: dict[int, int],
) -> dict[str, tuple[float, float]] | None:
    """Return the springs of a grid of a shape, by kind, if every one of them is there, and none else."""
    n_rows, n_columns, row_shift, column_shift = shape
    if n_columns < MIN_COLUMNS:
        return None
    springs: dict[str, tuple[float, float]] = {}
    expected = np.zeros(len(slots.masks), np.uint32)
    row, column = np.divmod(np.arange(n_rows * n_columns), n_columns)
    points = row * row_shift + column * column_shift
    left = dict(constants)
    for di, dj in (*KINDS, *sorted(SHEAR)):
        for sign in (1, -1):
            shift = sign * (di * row_shift + dj * column_shift)
            if shift not in left:
                continue
            name = KINDS.get((di, dj), "shear")
            if springs.setdefault(name, left[shift]) != left.pop(shift):
                return None
            i, j = row + sign * di, column + sign * dj
            exists = (i >= 0) & (i < n_rows) & (j >= 0) & (j < n_columns)
            expected[points] |= exists.astype(np.uint32) << np.uint32(bits[shift])
    if left or not np.array_equal(expected, slots.masks):
        return None
    return springs
