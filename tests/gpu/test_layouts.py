import re
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from gpu_xform.gpu import layouts
from gpu_xform.gpu.buffers import UNIFORM, Buffer
from gpu_xform.gpu.device import Device
from tests.support import wgsl
from tests.support.evaluate import evaluate


def declaration_of(name: str, stage: str, number_type: str | None = None) -> str:
    """Return a struct of a stage in WGSL, with what it needs."""
    code = wgsl.source(stage, number_type).code
    aliases = [line for line in code.splitlines() if line.startswith("alias ")]
    return "\n".join([*aliases, wgsl.struct(stage, name, number_type)])


def members_seen(
    device: Device, declaration: str, name: str, members: list[str], struct: npt.NDArray[Any]
) -> list[float]:
    """Return the value of each expression in `members` of the struct, as a shader reads it."""
    given = Buffer(device.context, struct.nbytes, UNIFORM, label="test")
    given.upload(layouts.as_bytes(struct))
    binding = f"@group(0) @binding(0) var<uniform> given: {name};"
    return evaluate(device, f"{declaration}\n{binding}", members, given)


@pytest.mark.parametrize(("dtype", "number_type"), [(np.float32, "f32"), (np.float64, "f64")])
def test_every_member_of_transform_lies_where_the_dtype_says(
    device: Device, dtype: npt.DTypeLike, number_type: str
) -> None:
    mirror = layouts.TRANSFORM[np.dtype(dtype)]
    struct = np.zeros((), mirror)
    struct["target_from_source"] = np.arange(1.0, 17.0).reshape(4, 4)
    struct["nan"] = 17.0
    struct["n_points"] = 18
    struct["first_packet"] = 19
    members = [f"given.target_from_source[{column}][{row}]" for column in range(4) for row in range(4)]
    members += ["given.nan", "given.n_points", "given.first_packet"]
    declaration = declaration_of("Transform", "transform_points", number_type)
    assert members_seen(device, declaration, "Transform", members, struct) == list(range(1, 20))
    assert set(mirror.names or ()) == set(re.findall(r"^\s+(\w+):", declaration, re.MULTILINE))


STRUCTS = [
    (layouts.TILE, "accumulate_lines", "Tile"),
    (layouts.STYLE, "accumulate_lines", "Style"),
    (layouts.FACES, "depth_small_triangles", "Faces"),
    (layouts.CANDIDATE, "extract_silhouette", "Candidate"),
    (layouts.VIEW, "extract_silhouette", "View"),
    (layouts.PIECE, "split_edges_by_visibility", "Piece"),
]


@pytest.mark.parametrize(("mirror", "stage", "name"), STRUCTS)
def test_every_member_lies_where_the_dtype_says(
    mirror: np.dtype[np.void], stage: str, name: str, device: Device
) -> None:
    struct: npt.NDArray[Any] = np.zeros((), mirror)
    members, number = [], 0
    for field in mirror.names or ():
        n_components = int(np.prod(mirror[field].shape))
        numbers = np.arange(number + 1, number + n_components + 1)
        struct[field] = numbers.reshape(mirror[field].shape)
        members += [f"given.{field}{f'[{i}]' if n_components > 1 else ''}" for i in range(n_components)]
        number += n_components
    declaration = declaration_of(name, stage)
    assert members_seen(device, declaration, name, members, struct) == list(range(1, number + 1))
    assert set(mirror.names or ()) == set(re.findall(r"^\s+(\w+):", declaration, re.MULTILINE))


@pytest.mark.parametrize(("dtype", "number_type"), [(np.float32, "f32"), (np.float64, "f64")])
def test_a_matrix_of_sixteen_distinct_entries_arrives_transposed_once(
    device: Device, dtype: npt.DTypeLike, number_type: str
) -> None:
    matrix = np.arange(1.0, 17.0).reshape(4, 4)
    struct = layouts.transform_structs(matrix[None], np.dtype(dtype), 7)[0]
    basis = ["1, 0, 0, 0", "0, 1, 0, 0", "0, 0, 1, 0", "0, 0, 0, 1"]
    columns = [f"(given.target_from_source * Vec4({vector}))[{row}]" for row in range(4) for vector in basis]
    declaration = declaration_of("Transform", "transform_points", number_type)
    assert members_seen(device, declaration, "Transform", columns, struct) == matrix.ravel().tolist()


def test_a_stack_of_matrices_is_transposed_one_by_one() -> None:
    stack = np.arange(48.0).reshape(3, 4, 4)
    np.testing.assert_array_equal(layouts.columns(stack), [matrix.T for matrix in stack])


def test_a_matrix_is_rounded_once() -> None:
    matrix = np.full((4, 4), 1.0 + 2.0**-24 + 2.0**-40)  # just over the middle of two single precision numbers
    struct = layouts.transform_structs(matrix[None], np.dtype(np.float32), 1)[0]
    assert (struct[:64].view(np.float32) == np.float32(1.0 + 2.0**-23)).all()


@pytest.mark.parametrize(
    ("mirror", "stage", "name", "number_type"),
    [
        *((*row, None) for row in STRUCTS),
        (layouts.SIXTEEN, "self_test", "Sixteen", None),
        (layouts.TRANSFORM[np.dtype(np.float32)], "transform_points", "Transform", "f32"),
        (layouts.TRANSFORM[np.dtype(np.float64)], "transform_points", "Transform", "f64"),
    ],
)
def test_the_structs_are_as_large_as_wgsl_makes_them(
    mirror: np.dtype[np.void], stage: str, name: str, number_type: str | None, device: Device
) -> None:
    n_bytes = 1 << 16  # of which another stride would hold another number of structs
    declarations = f"""{declaration_of(name, stage, number_type)}
@group(0) @binding(0) var<storage, read> given: array<{name}>;"""
    [n_structs] = evaluate(device, declarations, ["arrayLength(&given)"], Buffer(device.context, n_bytes, label="test"))
    assert n_structs == n_bytes // mirror.itemsize
