"""The loop over points that lie one behind the other: several at a time, in vectors of a processor's width.

LLVM does not make vectors of points by itself: what is x, y and z of eight points lies in three registers, crosswise.
"""

from functools import partial
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .compile import compile_loop

Array = npt.NDArray[Any]

VECTOR_BYTES = 32  # of a register of AVX2; LLVM takes two or four where they are narrower


@intrinsic  # type: ignore[untyped-decorator, unused-ignore]
def transform_group(
    typing_context: Any,  # noqa: ARG001
    source: Any,
    target: Any,
    first: Any,
    entries: Any,
) -> Any:
    """Write VECTOR_BYTES of each axis of `source` (n, 3), from the point `first` on, transformed, into `target` (n, 3).

    entries : the first three rows of a matrix; products are added from left to right, and contracted nowhere
    """
    n = VECTOR_BYTES // (source.dtype.bitwidth // 8)
    return types.void(source, target, first, entries), partial(_generate_group, n)


def _generate_group(n: int, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Emit the loads, the arithmetic and the stores of `n` points."""
    number = context.get_data_type(signature.args[0].dtype)
    axis_type, group_type, int32 = ir.VectorType(number, n), ir.VectorType(number, 3 * n), ir.IntType(32)

    def shuffle(a: Any, b: Any, order: list[int]) -> Any:
        return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(int32, len(order)), order))

    def repeat(value: Any) -> Any:
        nothing = ir.Constant(axis_type, ir.Undefined)
        return shuffle(builder.insert_element(nothing, value, ir.Constant(int32, 0)), nothing, [0] * n)

    places = []
    for kind, value in zip(signature.args[:2], arguments[:2], strict=True):
        data = context.make_array(kind)(context, builder, value).data
        start = builder.mul(arguments[2], ir.Constant(arguments[2].type, 3))
        places.append(builder.bitcast(builder.gep(data, [start]), ir.PointerType(group_type)))
    group = builder.load(places[0])
    group.align = 1  # arrays may begin anywhere
    axes = [shuffle(group, ir.Constant(group_type, ir.Undefined), list(range(c, 3 * n, 3))) for c in range(3)]
    m = [repeat(builder.extract_value(arguments[3], k)) for k in range(12)]
    moved = []
    for row in range(3):
        products = [builder.fmul(m[4 * row + c], axes[c]) for c in range(3)]
        total = builder.fadd(builder.fadd(products[0], products[1]), products[2])
        moved.append(builder.fadd(total, m[4 * row + 3]))
    x_and_y = shuffle(moved[0], moved[1], list(range(2 * n)))
    z_twice = shuffle(moved[2], moved[2], list(range(2 * n)))
    points = shuffle(x_and_y, z_twice, [place for i in range(n) for place in (i, n + i, 2 * n + i)])
    store = builder.store(points, places[1])
    store.align = 1
    return context.get_dummy_value()


@compile_loop
def transform_packed(points: Array, matrices: Array, out: Array, starts: Array) -> None:
    """Write each of `matrices` (k, 4, 4) applied to points (n, 3) into `out` (k, n, 3), all of them C-ordered."""
    n_blocks, group = len(starts) - 1, VECTOR_BYTES // points.itemsize
    for task in numba.prange(len(matrices) * n_blocks):
        m, first, end = matrices[task // n_blocks], starts[task % n_blocks], starts[task % n_blocks + 1]
        source, target = points[first:end], out[task // n_blocks, first:end]
        xx, xy, xz, xw = m[0, 0], m[0, 1], m[0, 2], m[0, 3]
        yx, yy, yz, yw = m[1, 0], m[1, 1], m[1, 2], m[1, 3]
        zx, zy, zz, zw = m[2, 0], m[2, 1], m[2, 2], m[2, 3]
        n_grouped = np.int64(len(source) // group * group)
        for i in range(0, n_grouped, group):
            transform_group(source, target, i, (xx, xy, xz, xw, yx, yy, yz, yw, zx, zy, zz, zw))
        for i in range(n_grouped, len(source)):
            x, y, z = source[i, 0], source[i, 1], source[i, 2]
            target[i, 0] = xx * x + xy * y + xz * z + xw
            target[i, 1] = yx * x + yy * y + yz * z + yw
            target[i, 2] = zx * x + zy * y + zz * z + zw
