"""What completion and help show of the functions that take a style."""

import inspect
from importlib import import_module
from typing import Any, get_type_hints

import pytest

import gpu_xform as gx
from gpu_xform.drawing.layer import Style

TAKE_A_STYLE = ("render", "render_array", "render_svg", "render_pdf", "animate", "turntable", "view", "save_page")
COMPLETED = [f"gx.{name}(mesh, line_w" for name in (*TAKE_A_STYLE, "Layer")]
PLAIN = gx.Layer(gx.samples.cube())


@pytest.mark.parametrize("name", TAKE_A_STYLE)
def test_signatures_show_every_style_keyword_with_its_default(name: str) -> None:
    shown = inspect.signature(getattr(gx, name)).parameters
    for keyword in Style.__annotations__:
        assert shown[keyword].kind is inspect.Parameter.KEYWORD_ONLY
        assert shown[keyword].default == getattr(PLAIN, keyword)
    assert not any(parameter.kind is inspect.Parameter.VAR_KEYWORD for parameter in shown.values())


def test_a_turntable_shows_what_animations_take_but_the_number_of_frames_twice() -> None:
    shown = inspect.signature(gx.turntable).parameters
    assert {"frames", "axis", "fps", "camera", "line_width"} <= shown.keys()
    assert "n_frames" not in shown


def test_signatures_show_names_of_types_not_what_they_stand_for() -> None:
    for name in (name for name in gx.__all__ if inspect.isfunction(getattr(gx, name))):
        shown = str(inspect.signature(getattr(gx, name)))
        assert len(shown) < 1500, name
        assert "numpy._typing" not in shown, name


def test_annotations_of_public_names_are_found() -> None:
    for name in gx.__all__:
        value = getattr(gx, name)
        if inspect.isclass(value):
            get_type_hints(value)


@pytest.mark.parametrize("use_jedi", [False, True])
@pytest.mark.parametrize("call", COMPLETED)
def test_ipython_completes_style_keywords(call: str, use_jedi: bool) -> None:
    completer: Any = import_module("IPython.core.completer")
    own = completer.IPCompleter(namespace={"gx": gx}, use_jedi=use_jedi)
    with completer.provisionalcompleter():
        found = [completion.text for completion in own.completions(call, len(call))]
    assert any(text.startswith("line_width") for text in found)


@pytest.mark.parametrize("module", [gx, gx.samples, gx.planar, gx.dask], ids=lambda module: module.__name__)
def test_completion_lists_public_names_alone(module: Any) -> None:
    assert {name for name in dir(module) if not name.startswith("__")} <= {*module.__all__, "errors"}


def test_kin_of_render_describe_its_parameters_in_its_words() -> None:
    described = inspect.getdoc(gx.render) or ""
    legend = described[described.index("legend : ") : described.index("font : ")]
    for kin in (gx.render_array, gx.render_svg, gx.render_pdf):
        assert legend in (inspect.getdoc(kin) or "")
        assert "as `render` takes them" not in (inspect.getdoc(kin) or "")
