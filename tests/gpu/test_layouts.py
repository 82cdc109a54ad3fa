"""The dtypes of `layouts` lie in memory as WGSL lays out its structs: measured on the device, not believed."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from gpu_xform.gpu import layouts
from gpu_xform.gpu.buffers import UNIFORM, Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.triangles import HEAD_BYTES
from tests.support import wgsl
from tests.support.evaluate import evaluate

SINGLE, DOUBLE = np.dtype(np.float32), np.dtype(np.float64)

STRUCTS = [
    ("Transform", "transform_points", "f32", layouts.TRANSFORM[SINGLE]),
    ("Transform", "transform_points", "f64", layouts.TRANSFORM[DOUBLE]),
    ("ConvolutionPass", "convolve", "f32", layouts.CONVOLUTION_PASS[SINGLE]),
    ("ConvolutionPass", "convolve", "f64", layouts.CONVOLUTION_PASS[DOUBLE]),
    ("VertexTransform", "vertex_transform", "f32", layouts.VERTEX_TRANSFORM),
    ("Tile", "accumulate_lines", None, layouts.TILE),
    ("DepthCue", "accumulate_lines", None, layouts.DEPTH_CUE),
    ("LineStyle", "accumulate_lines", None, layouts.LINE_STYLE),
    ("Faces", "depth_small_triangles", None, layouts.FACES),
    ("Splat", "splat_points", None, layouts.SPLAT),
    ("PixelDots", "keep_dot_colors", None, layouts.PIXEL_DOTS),
    ("ExtremesQuery", "find_extremes", None, layouts.EXTREMES_QUERY),
    ("Extremes", "find_extremes", None, layouts.EXTREMES),
    ("Candidate", "extract_silhouette", None, layouts.CANDIDATE),
    ("SilhouetteView", "extract_silhouette", None, layouts.SILHOUETTE_VIEW),
    ("Span", "split_edges_by_visibility", None, layouts.SPAN),
    ("ChainEdge", "measure_chains", None, layouts.CHAIN_EDGE),
    ("CountOrWrite", "split_edges_by_visibility", None, layouts.COUNT_OR_WRITE),
    ("SpringStep", "step_springs", None, layouts.SPRING_STEP),
    ("SlotPacket", "step_springs", None, layouts.SLOT_PACKET),
    ("GridSprings", "step_grid", None, layouts.GRID_SPRINGS),
    ("Obstacle", "step_springs", None, layouts.OBSTACLE),
    ("Pin", "place_pins", None, layouts.PIN),
    ("SelfTest", "self_test", None, layouts.SELF_TEST),
]

ONLY_ON_THE_DEVICE = {
    "GrowingList": "the host clears its head",
    "PointList": "shaders write and read it",
    "IndexedDraw": "a dispatch writes it for the draw that it is named after",
    "SectionEnd": "a first dispatch writes it for a second one",
    "LargeTriangles": "the host clears its head, and dispatches by it",
    "GrowingEdgeList": "the host clears its head, and dispatches by it",
    "EdgeList": "shaders write and read it",
    "GrowingTriangleList": "the host clears its head, and dispatches by it",
    "TriangleList": "shaders write and read it",
}

EVERY_STRUCT = pytest.mark.parametrize(("name", "stage", "number_type", "mirror"), STRUCTS)


def structs_in(code: str) -> dict[str, str]:
    """Return the text of every struct of resolved WGSL, by name."""
    return {name: text for text, name in re.findall(r"^(struct (\w+) \{.*?^\})", code, re.MULTILINE | re.DOTALL)}


def declarations(stage: str, number_type: str | None) -> str:
    """Return the structs of a stage in WGSL, with what they need."""
    code = wgsl.source(stage, number_type).code
    others = [line for line in code.splitlines() if re.match(r"alias |const ", line)]
    return "\n".join([*others, *structs_in(code).values()])


def leaves(dtype: np.dtype[Any], path: str) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Yield every number of a struct: as an expression of WGSL, and as the indices that lead to it in NumPy."""
    for name in dtype.names or ():
        field = dtype[name]
        if field.names:
            yield from ((expression, (name, *keys)) for expression, keys in leaves(field, f"{path}.{name}"))
        else:
            for index in np.ndindex(field.shape):
                yield f"{path}.{name}" + "".join(f"[{i}]" for i in index), (name, *([index] if index else []))


def members_seen(
    device: GpuDevice, declaration: str, name: str, members: list[str], struct: npt.NDArray[Any]
) -> list[float]:
    """Return the value of each expression in `members` of the struct, as a shader reads it."""
    given = Buffer(device.context, struct.nbytes, UNIFORM, label="test")
    given.upload(layouts.as_bytes(struct))
    binding = f"@group(0) @binding(0) var<uniform> given: {name};"
    return evaluate(device, f"{declaration}\n{binding}", members, given)


def test_every_struct_that_a_stage_binds_is_here() -> None:
    bound: set[str] = set()
    for stage, number_type in wgsl.VARIANTS:
        code = wgsl.source(stage, number_type).code
        structs = structs_in(code)
        types = re.findall(r"^@group\(0\) @binding\(\d+\) var.*?: (.*?);", code, re.MULTILINE)
        while types:
            names = {word for text in types for word in re.findall(r"\w+", text)} & set(structs)
            bound |= names
            types = [structs[name].partition("{")[2] for name in names]
    assert bound == {name for name, *_ in STRUCTS} | set(ONLY_ON_THE_DEVICE)


def test_every_layout_is_here() -> None:
    dtypes = {id(value) for value in vars(layouts).values() if isinstance(value, np.dtype)}
    for by_number_type in (layouts.TRANSFORM, layouts.CONVOLUTION_PASS):
        dtypes |= {id(value) for value in by_number_type.values()}
    assert dtypes == {id(mirror) for *_, mirror in STRUCTS}


@EVERY_STRUCT
def test_every_member_lies_where_the_dtype_says(
    name: str, stage: str, number_type: str | None, mirror: np.dtype[np.void], device: GpuDevice
) -> None:
    struct: npt.NDArray[Any] = np.zeros((), mirror)
    members = list(leaves(mirror, "given"))
    for number, (_, (*path, last)) in enumerate(members, 1):
        place: Any = struct
        for key in path:
            place = place[key]
        place[last] = number
    expressions = [expression for expression, _ in members]
    seen = members_seen(device, declarations(stage, number_type), name, expressions, struct)
    assert seen == list(range(1, len(members) + 1))


@EVERY_STRUCT
def test_every_member_is_named_as_in_the_dtype(
    name: str, stage: str, number_type: str | None, mirror: np.dtype[np.void]
) -> None:
    members = re.findall(r"^    (\w+):", wgsl.struct(stage, name, number_type), re.MULTILINE)
    assert tuple(members) == mirror.names


@EVERY_STRUCT
def test_the_structs_are_as_large_as_wgsl_makes_them(
    name: str, stage: str, number_type: str | None, mirror: np.dtype[np.void], device: GpuDevice
) -> None:
    n_bytes = 1 << 16  # of which another stride would hold another number of structs
    declaration = f"""{declarations(stage, number_type)}
@group(0) @binding(0) var<storage, read> given: array<{name}>;"""
    [n_structs] = evaluate(device, declaration, ["arrayLength(&given)"], Buffer(device.context, n_bytes, label="test"))
    assert n_structs == n_bytes // mirror.itemsize


@pytest.mark.parametrize(
    ("name", "stage", "access", "head_bytes"),
    [
        ("LargeTriangles", "depth_small_triangles", "read_write", HEAD_BYTES),
        ("LargeTriangles", "depth_large_triangles", "read", HEAD_BYTES),
    ],
)
def test_lists_of_the_device_have_a_head_as_large_as_the_host_clears(
    name: str, stage: str, access: str, head_bytes: int, device: GpuDevice
) -> None:
    declaration = f"""{wgsl.struct(stage, name)}
@group(0) @binding(0) var<storage, {access}> given: {name};"""
    buffer = Buffer(device.context, 256, label="test")
    [n_indices] = evaluate(device, declaration, ["arrayLength(&given.indices)"], buffer)
    assert n_indices == (256 - head_bytes) // 4


@pytest.mark.parametrize(("dtype", "number_type"), [(SINGLE, "f32"), (DOUBLE, "f64")])
def test_a_matrix_of_sixteen_distinct_entries_arrives_transposed_once(
    device: GpuDevice, dtype: np.dtype[Any], number_type: str
) -> None:
    matrix = np.arange(1.0, 17.0).reshape(4, 4)
    struct = layouts.pack_transforms(matrix[None], dtype, 7)[0]
    basis = ["1, 0, 0, 0", "0, 1, 0, 0", "0, 0, 1, 0", "0, 0, 0, 1"]
    columns = [f"(given.target_from_source * Vec4({vector}))[{row}]" for row in range(4) for vector in basis]
    declaration = declarations("transform_points", number_type)
    assert members_seen(device, declaration, "Transform", columns, struct) == matrix.ravel().tolist()


def test_a_stack_of_matrices_is_transposed_one_by_one() -> None:
    stack = np.arange(48.0).reshape(3, 4, 4)
    np.testing.assert_array_equal(layouts.to_column_major(stack), [matrix.T for matrix in stack])


def test_a_matrix_is_rounded_once() -> None:
    matrix = np.full((4, 4), 1.0 + 2.0**-24 + 2.0**-40)  # just over the middle of two single precision numbers
    struct = layouts.pack_transforms(matrix[None], SINGLE, 1)[0]
    assert (struct[:64].view(np.float32) == np.float32(1.0 + 2.0**-23)).all()
