"""Signatures that name the style keywords, and parameters described once, for completion and help."""

import inspect
import re
from collections.abc import Callable
from inspect import Parameter
from typing import Any, TypeVar

from .layer import style_parameters

_Function = TypeVar("_Function", bound=Callable[..., Any])
_SHARED = re.compile(r"^((?:[*\w]+, )*[*\w]+) : as `render` takes them$", re.MULTILINE)
_PARAMETER = re.compile(r"^([*\w]+)(?: : .*)?\n(?: {4}.*(?:\n|\Z))+", re.MULTILINE)


def show_style_keywords(function: _Function) -> _Function:
    """Show the style keywords and their defaults in the signature of a function, in place of its `**style`."""
    return _replace_last(function, style_parameters())


def show_keywords_of(source: Callable[..., Any], *, but: str) -> Callable[[_Function], _Function]:
    """Return what shows the keywords of `source`, all `but` one, in place of a function's `**options`."""

    def show(function: _Function) -> _Function:
        keywords = inspect.signature(source).parameters.values()
        return _replace_last(
            function, [each for each in keywords if each.kind is each.KEYWORD_ONLY and each.name != but]
        )

    return show


def describe_parameters_of(source: Callable[..., Any]) -> Callable[[_Function], _Function]:
    """Return what puts the descriptions of `source` in place of "a, b : as `render` takes them" in a docstring."""

    def describe(function: _Function) -> _Function:
        known = {found[1]: found[0].rstrip() for found in _PARAMETER.finditer(inspect.getdoc(source) or "")}
        own = inspect.getdoc(function)
        if own is not None and known:  # Python leaves docstrings out on request
            function.__doc__ = _SHARED.sub(
                lambda found: "\n".join(known[name] for name in found[1].replace(",", " ").split()), own
            )
        return function

    return describe


def _replace_last(function: _Function, keywords: list[Parameter]) -> _Function:
    signature = inspect.signature(function)
    *own, _ = signature.parameters.values()
    own += [keyword for keyword in keywords if keyword.name not in signature.parameters]
    function.__signature__ = signature.replace(parameters=own)  # type: ignore[attr-defined]
    return function
