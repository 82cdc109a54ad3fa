"""Annotation options: the keywords of `render` and its kin that ask for text in a picture."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from .._core.types import StrPath

LegendLike: TypeAlias = bool | Sequence[str | None]
AxesLike: TypeAlias = bool | Sequence[str | None]


@dataclass(frozen=True)
class AnnotationOptions:
    """What a picture is annotated with, as the arguments of `render` of these names give it."""

    axes: AxesLike = False
    legend: LegendLike = False
    font: StrPath | None = None
    font_size: float | None = None


NO_OPTIONS = AnnotationOptions()


def scale_font(options: AnnotationOptions, pixel_ratio: float) -> AnnotationOptions:
    """Return the options with a font that was given in logical pixels at its size in physical ones."""
    return options if options.font_size is None else replace(options, font_size=options.font_size * pixel_ratio)
