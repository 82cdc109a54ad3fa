"""Each enumeration has one source, and all that can be chosen works."""

import pytest

from gpu_xform import Layer, Mesh, matrices, render_svg, samples
from gpu_xform.cli.argument_types import styles
from gpu_xform.drawing.enums import HIDDEN_STYLES, Hidden, HiddenStyle
from gpu_xform.geometry.edges import EDGE_SETS, EdgeSet


def test_every_hidden_style_has_a_number_of_its_name() -> None:
    modes = [mode for mode in Hidden if mode is not Hidden.ONLY]  # which draws hidden parts in a style of their own
    assert [Hidden.from_style(style) for style in HIDDEN_STYLES] == modes
    assert tuple(mode.name.lower() for mode in modes) == HIDDEN_STYLES


@pytest.mark.parametrize("style", HIDDEN_STYLES)
def test_every_hidden_style_is_taken(style: HiddenStyle) -> None:
    assert Layer(samples.cube(), hidden=style).hidden == style
    assert styles.parse_hidden(style) == style


@pytest.mark.parametrize("edges", EDGE_SETS)
def test_every_edge_set_is_taken(edges: EdgeSet) -> None:
    cube = samples.cube()
    open_box = Mesh(cube.positions, cube.faces[1:])
    models = [open_box, open_box.transformed(matrices.translate(0.5, 0.4, 0.3))]  # which intersect
    assert "<path" in render_svg(models, edges=edges, size=(32, 32))
    assert styles.parse_edge_sets(edges) == [edges]
