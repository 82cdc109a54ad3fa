"""What `help()` says: each public function and method lists its own parameters, by NumPyDoc's headings."""

import inspect
import re
import types
from collections.abc import Callable, Iterator
from typing import Any

import gpu_xform as gx
from gpu_xform.geometry.nodes import Node
from gpu_xform.imaging.compare import Difference
from gpu_xform.matrices import Decomposition

CLASSES = [gx.Animation, gx.Camera, gx.Layer, gx.Mesh, gx.Scene, gx.Springs, gx.Trajectory, Decomposition, Difference]
CLASSES += [Node]


def public_functions() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Yield the functions of the package, of `planar` and of `samples`, and the methods of its classes."""
    for name in gx.__all__:
        if inspect.isfunction(getattr(gx, name)):
            yield name, getattr(gx, name)
    for module in (gx.planar, gx.samples):
        for name, value in vars(module).items():
            if inspect.isfunction(value) and value.__module__ == module.__name__ and not name.startswith("_"):
                yield f"{module.__name__}.{name}", value
    for owner in CLASSES:
        for name, value in vars(owner).items():
            method = getattr(value, "__func__", value)
            if inspect.isfunction(method) and not name.startswith("_"):
                yield f"{owner.__name__}.{name}", method


FUNCTIONS = dict(public_functions())


def section(docstring: str, title: str) -> str:
    """Return the text below a heading, up to the next one; none if there is no such heading."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=^\w[\w ]*\n---|\Z)", docstring, re.DOTALL | re.MULTILINE)
    return found[1] if found else ""


def documented_parameters(docstring: str) -> list[str]:
    """Return the names that the section Parameters describes, in their order."""
    heads = re.findall(r"^(\S[^:\n]*?)(?: : .*)?$", section(docstring, "Parameters"), re.MULTILINE)
    return [name.strip().lstrip("*") for head in heads for name in head.split(",")]


def test_every_parameter_is_described_in_its_order() -> None:
    for name in sorted(FUNCTIONS):
        function = FUNCTIONS[name]
        # Without the keywords that a signature shows in place of `**style`.
        written = types.FunctionType(function.__code__, {})
        parameters = [
            parameter for parameter in inspect.signature(written).parameters if parameter not in ("self", "cls")
        ]
        assert documented_parameters(inspect.getdoc(function) or "") == parameters, name


def test_a_result_is_described() -> None:
    for name in sorted(FUNCTIONS):
        function = FUNCTIONS[name]
        returns = inspect.signature(function).return_annotation not in ("None", None, inspect.Signature.empty)
        assert bool(section(inspect.getdoc(function) or "", "Returns")) == returns, name


def test_the_section_of_parameters_is_found() -> None:
    assert len(FUNCTIONS) > 70
    assert documented_parameters(
        "A.\n\nParameters\n----------\na, b : int\n    Both.\n**c\n    More.\n\nReturns\n-------\nint\n"
    ) == [*("a", "b", "c")]
