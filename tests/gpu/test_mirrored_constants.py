"""What is written both in Python and in WGSL is the same in both."""

import math
import re

import pytest

from gpu_xform.compute.kernels.convolve import Format
from gpu_xform.compute.kernels.job import Epilogue
from gpu_xform.compute.kernels.transform import MATRICES_PER_DISPATCH
from gpu_xform.drawing.cloud_points import NOT_FOUND
from gpu_xform.drawing.dash_chains import CHAIN_IS_FIRST, CHAIN_IS_REVERSED
from gpu_xform.drawing.draw_list import NO_POINT
from gpu_xform.drawing.enums import HIDDEN_FADE_ALPHA, ColorMode, Dashes, Hidden
from gpu_xform.drawing.point_colors import Coloring
from gpu_xform.drawing.shading import AMBIENT
from gpu_xform.drawing.silhouettes import EDGE_ON_SINE, NO_FACE
from gpu_xform.gpu.self_test import MAX_ITERATIONS
from gpu_xform.raster.clouds import BLOCK_SIDE_PX
from gpu_xform.raster.compute.seen_edges import CELL_PX
from gpu_xform.raster.dashes import EDGES_PER_SECTION
from gpu_xform.raster.hardware.edge_lists import FANOUT, LISTS, N_LISTS
from gpu_xform.raster.line_stage import BLOCK_EDGES
from gpu_xform.raster.quads import QUAD_TRIANGLES, QUAD_VERTICES
from gpu_xform.raster.triangles import OPACITY_BITS
from gpu_xform.simulation.incidence import MAX_PACKETS, Slots
from gpu_xform.simulation.obstacles import MAX_OBSTACLES
from gpu_xform.simulation.point_state import TEXELS_PER_ROW
from gpu_xform.vector.painters.overlaps import DEPTH_RTOL
from tests.support.wgsl import FOLDER, STAGES

ENUMERATIONS = {
    "HIDDEN": Hidden,
    "DASHES": Dashes,
    "COLOR": ColorMode,
    "COLORING": Coloring,
    "EPILOGUE": Epilogue,
    "SLOTS": Slots,
    "FORMAT": Format,
}

TWINS = {
    "AMBIENT": AMBIENT,
    **{f"{prefix}_{member.name}": member for prefix, enumeration in ENUMERATIONS.items() for member in enumeration},
    "BLOCK_EDGES": BLOCK_EDGES,
    "CELL_PX": CELL_PX,
    "CHAIN_EDGE_MASK": float(~(CHAIN_IS_FIRST | CHAIN_IS_REVERSED)),
    "CHAIN_IS_FIRST": float(CHAIN_IS_FIRST),
    "CHAIN_IS_REVERSED": float(CHAIN_IS_REVERSED),
    "BLOCK_SIDE": BLOCK_SIDE_PX,
    "COPLANAR_FACTOR": 1.0 + DEPTH_RTOL,
    "EDGE_ON_SINE": EDGE_ON_SINE,
    "EDGES_PER_SECTION": EDGES_PER_SECTION,
    "LIST_SHOWN": LISTS.index(Hidden.SHOW),
    "LIST_UNKNOWN": LISTS.index(Hidden.REMOVE),
    "LOG2_FANOUT": math.log2(FANOUT),
    "N_LISTS": N_LISTS,
    "QUAD_INDICES": len(QUAD_TRIANGLES),
    "QUAD_VERTICES": QUAD_VERTICES,
    "HIDDEN_FADE_ALPHA": HIDDEN_FADE_ALPHA,
    "MATRICES_PER_DISPATCH": MATRICES_PER_DISPATCH,
    "MAX_OBSTACLES": MAX_OBSTACLES,
    "MAX_PACKETS": MAX_PACKETS,
    "MAX_ROUNDS": MAX_ITERATIONS,
    "NOT_FOUND": NOT_FOUND,
    "NO_FACE": NO_FACE,
    "NO_POINT": NO_POINT,
    "OPACITY_BITS": OPACITY_BITS,
    "TEXELS_PER_ROW": TEXELS_PER_ROW,
}

WGSL_ALONE = {
    "COVER_MARGIN_PX": "only the shaders draw quads",
    "BOXES_PER_SLIVER": "only the shaders rasterise triangles",
    "COLUMN_ERROR": "only the shaders rasterise triangles",
    "CONSERVATIVE_MARGIN_PX": "only the shaders rasterise triangles",
    "DEPTH_BIAS_PX": "only the shaders test depths",
    "COLLINEAR_TOLERANCE_PX": "only the shaders look up depths",
    "FLAT_TOLERANCE_PX": "only the shaders look up depths",
    "EDGE_HIDDEN": "only the shaders look up depths",
    "EDGE_SHOWN": "only the shaders look up depths",
    "EDGE_UNKNOWN": "only the shaders look up depths",
    "LARGEST": "only the shader looks for extremes",
    "MAX_BANDS": "the shaders choose their own grid",
    "MAX_FLAT_SLOPE": "only the shaders look up depths",
    "MAX_PROBED_PX": "only the shaders look up depths",
    "MAX_SLIVER_PX": "the shaders choose their own grid",
    "MAX_SMALL_TRIANGLE_PX": "the shaders choose their own grid",
    "MAX_WORKGROUPS": "the shaders choose their own grid; the number is WebGPU's",
    "MIN_SEEN_OPACITY": "half a step of the eight bits that shaders pack",
    "MIN_WORKGROUPS": "the shaders choose their own grid",
    "NOWHERE": "only the shaders draw quads",
    "ON_AXIS_PX": "only the shaders look up depths",
    "OPACITY_STEPS": "shaders pack and unpack it",
    "OPAQUE_ABSORBANCE": "shaders write and read absorbance",
    "PIXELS_PER_BAND": "the shaders choose their own grid",
    "ROUNDING_PX": "only the shaders look up depths",
    "SATURATED_ABSORBANCE": "shaders write and read absorbance",
    "TINY": "only the shader divides by lengths",
    "SILHOUETTE_PROBE_PX": "only the shaders look up depths; the margin of tiles has room for it",
}


def written_constants() -> list[tuple[str, str]]:
    """Return the name and the text of every constant of every WGSL file."""
    texts = [file.read_text("utf-8") for file in sorted(FOLDER.rglob("*.wgsl"))]
    return [found for text in texts for found in re.findall(r"^const (\w+)(?:: \w+)? = (.+?);", text, re.MULTILINE)]


def value(text: str) -> float:
    """Return the number that a constant expression of WGSL stands for: literals and sums or quotients of them."""
    literals = re.findall(r"0x[0-9a-f]+u?|[\d.]+(?:e-?\d+)?[uif]?|[-+/]", text)
    assert "".join(literals) == text.replace(" ", "")
    numbers = [
        float(int(literal.rstrip("u"), 16)) if literal.startswith("0x") else float(literal.rstrip("uif"))
        for literal in literals[::2]
    ]
    result = numbers[0]
    for operator, number in zip(literals[1::2], numbers[1:], strict=True):
        result = {"+": result + number, "-": result - number, "/": result / number}[operator]
    return result


def test_constant_expressions_of_wgsl_are_read() -> None:
    assert [value(text) for text in ("8", "0xffu", "1.5", "1e-6", "1.0 + 1e-6", "0.5 / 255.0", "8u")] == [
        *(8.0, 255.0, 1.5, 1e-6, 1.0 + 1e-6, 0.5 / 255.0, 8.0)
    ]


def test_every_constant_of_the_shaders_has_a_twin_or_a_reason_to_have_none() -> None:
    assert {name for name, _ in written_constants()} == set(TWINS) | set(WGSL_ALONE)
    assert not set(TWINS) & set(WGSL_ALONE)


def test_constants_are_the_same_in_both() -> None:
    for name, text in written_constants():
        if name in TWINS:
            assert value(text) == float(TWINS[name]), name


def test_no_two_files_mean_different_things_by_one_constant() -> None:
    texts = dict(written_constants())
    assert all(texts[name] == text for name, text in written_constants())


@pytest.mark.parametrize(
    ("constant", "enumeration"),
    [
        *(("hidden", Hidden), ("dashes", Dashes), ("color_mode", ColorMode)),
        *(("epilogue", Epilogue), ("slots", Slots), ("coloring", Coloring)),
    ],
)
def test_the_table_of_stages_has_every_member_of_an_enumeration(
    constant: str, enumeration: type[Hidden | Dashes | ColorMode | Epilogue | Slots | Coloring]
) -> None:
    values = [stage.values[constant] for stage in STAGES.values() if constant in stage.overrides.get("u32", ())]
    assert tuple(enumeration) in values
    assert all(found == tuple(enumeration) or len(found) == 1 for found in values)
