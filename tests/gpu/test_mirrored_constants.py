"""What is written both in Python and in WGSL is the same in both."""

from enum import IntEnum

import pytest

from gpu_xform.compute.kernels.job import Epilogue
from gpu_xform.drawing.enums import ColorMode, Hidden
from gpu_xform.raster.compute.triangles import LEFT_BITS
from gpu_xform.vector.build_layers import HIDDEN_FADE_ALPHA
from gpu_xform.vector.layer import DASH_OFF_WIDTHS, DASH_ON_WIDTHS, MIN_DASH_WIDTH_PX
from gpu_xform.vector.painters.overlaps import DEPTH_RTOL
from tests.support.wgsl import constants, source


def test_passes_name_bits_of_marks_as_the_shaders_do() -> None:
    assert constants("composite_triangles")["LEFT_BITS"] == f"{LEFT_BITS}u"


def test_vector_pictures_fade_and_dash_as_the_shaders_do() -> None:
    there = constants("accumulate_lines")
    assert float(there["PALE"]) == HIDDEN_FADE_ALPHA
    assert there["DASH"] == f"vec2({DASH_ON_WIDTHS}, {DASH_OFF_WIDTHS})"
    assert f"DASH * max(style.line_width, {MIN_DASH_WIDTH_PX});" in source("accumulate_lines").code


def test_what_is_level_in_vector_pictures_is_so_in_the_shaders() -> None:
    assert constants("depth_small_triangles")["NEARLY"] == f"1.0 + {DEPTH_RTOL:.0e}".replace("e-0", "e-")


@pytest.mark.parametrize(
    ("stage", "names"),
    [
        ("accumulate_lines", {f"HIDDEN_{member.name}": member for member in Hidden}),
        ("accumulate_colored_lines", {f"COLOR_{member.name}": member for member in ColorMode}),
        (
            "transform_points",
            {
                "EPILOGUE_NONE": Epilogue.NONE,
                "EPILOGUE_PERSPECTIVE_DIVIDE": Epilogue.PERSPECTIVE_DIVIDE,
                "EPILOGUE_NORMALIZE": Epilogue.NORMALIZE,
            },
        ),
    ],
)
def test_numbers_that_stand_for_names_are_the_shaders_own(stage: str, names: dict[str, IntEnum]) -> None:
    there = constants(stage)
    assert {name: there[name] for name in names} == {name: f"{member.value}u" for name, member in names.items()}
