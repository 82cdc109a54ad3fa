from collections.abc import Callable
from typing import Any

import cmap
import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import Normalize

from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.imaging.colormaps import apply_colormap
from tests.support.types import Array

# Of matplotlib's names the one whose colours the package cmap (0.8) has not as matplotlib has them.
WRONG_IN_CMAP = {"gist_stern", "gist_stern_r"}

SCALARS = np.random.default_rng(7).normal(3.0, 2.0, 2001)
SCALARS[[5, 700]] = np.nan


def by_matplotlib(scalars: Array, name: str, clim: tuple[float, float] | None) -> Array:
    low, high = clim or (None, None)
    place = Normalize(low, high)(np.ma.masked_invalid(scalars))
    return np.asarray(matplotlib.colormaps[name](place))


@pytest.mark.slow
@pytest.mark.parametrize("clim", [None, (1.5, 4.0), (-20.0, 30.0)], ids=str)
def test_every_name_of_matplotlibs_gives_its_colours(clim: tuple[float, float] | None) -> None:
    assert len(matplotlib.colormaps) > 150
    for name in set(matplotlib.colormaps) - WRONG_IN_CMAP:
        colors = apply_colormap(SCALARS, name, clim, len(SCALARS))
        assert colors.dtype == np.float64
        assert np.abs(colors - by_matplotlib(SCALARS, name, clim)).max() < 1e-4, name


def test_a_number_where_two_colours_meet_takes_the_one_that_matplotlib_gives() -> None:
    steps = np.arange(257) / 256
    for near in (steps, np.nextafter(steps, -1.0), np.nextafter(steps, 2.0)):
        expected = by_matplotlib(near, "turbo", (0.0, 1.0))
        assert (apply_colormap(near, "turbo", (0.0, 1.0), 257) == expected).all()


@pytest.mark.parametrize(
    "extremes", [{}, {"bad": "#11223380", "under": "red", "over": "blue"}], ids=["plain", "with extremes"]
)
def test_a_colormap_of_matplotlib_or_of_cmap_keeps_its_own_extremes(extremes: dict[str, str]) -> None:
    theirs = matplotlib.colormaps["viridis"].with_extremes(**extremes)
    expected = theirs(Normalize(1.5, 4.0)(np.ma.masked_invalid(SCALARS)))
    for colormap in (theirs, cmap.Colormap("viridis").with_extremes(**extremes)):
        assert np.abs(apply_colormap(SCALARS, colormap, (1.5, 4.0), len(SCALARS)) - expected).max() < 1e-9
    assert len(np.unique(expected, axis=0)) > 100


def test_any_other_callable_is_given_numbers_from_0_to_1_only() -> None:
    seen = []

    def ramp(places: Array) -> Array:
        seen.append(places)
        return np.column_stack([places, 1 - places, 0 * places, 0.5 + 0 * places])

    colors = apply_colormap([-3.0, np.nan, 1.0, 2.0, 3.0, 99.0], ramp, (1.0, 5.0), 6)
    assert [places.tolist() for places in seen] == [[0.0, 0.0, 0.25, 0.5, 1.0]]
    assert colors.tolist() == [
        [0.0, 1.0, 0.0, 0.5],
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.5],
        [0.25, 0.75, 0.0, 0.5],
        [0.5, 0.5, 0.0, 0.5],
        [1.0, 0.0, 0.0, 0.5],
    ]


def test_a_callable_may_leave_out_alpha() -> None:
    assert apply_colormap([0, 1], lambda t: np.column_stack([t, t, t]), None, 2).tolist() == [
        [0, 0, 0, 1],
        [1, 1, 1, 1],
    ]


def test_nan_and_what_is_masked_are_transparent_and_do_not_stretch_the_limits() -> None:
    masked = np.ma.MaskedArray([1, 2, 900, 3], mask=[False, False, True, False])
    for scalars in ([1.0, 2.0, np.nan, 3.0], masked):
        colors = apply_colormap(scalars, "viridis", None, 4)
        assert colors[2].tolist() == [0.0, 0.0, 0.0, 0.0]
        assert (colors[[0, 1, 3]] == apply_colormap([1, 2, 3], "viridis", None, 3)).all()
    assert (apply_colormap([np.nan] * 3, "viridis", None, 3) == 0.0).all()


@pytest.mark.parametrize("value", [0.0, -7.5, 1e308, 5e-324])
def test_scalars_that_are_all_the_same_take_the_first_colour(value: float) -> None:
    colors = apply_colormap([value, np.nan, value], "viridis", None, 3)
    assert (colors[[0, 2]] == by_matplotlib(np.array([0.0]), "viridis", (0.0, 1.0))).all()
    assert (apply_colormap([value, value], "viridis", (value, value), 2) == colors[0]).all()


@given(st.lists(st.floats(allow_infinity=False), min_size=1, max_size=8), st.floats(0, 1), st.floats(0, 1))
def test_any_finite_numbers_make_colours_in_their_order(values: list[float], a: float, b: float) -> None:
    finite = sorted(value for value in values if not np.isnan(value))
    limits = None if not finite else sorted((finite[0] * a, finite[-1] * b))
    for clim in (None, limits):
        greys = apply_colormap(values, lambda t: np.column_stack([t, t, t]), clim, len(values))
        assert ((greys[:, 3] == 0) == np.isnan(values)).all()
        drawn = greys[np.argsort(values)][: len(finite), 0]
        assert (np.diff(drawn) >= 0).all()
        if clim is None and finite and finite[-1] - finite[0] > 1e-300:
            assert (drawn[0], drawn[-1]) == (0.0, 1.0)


def test_no_points_have_no_colours() -> None:
    for colormap in ("viridis", matplotlib.colormaps["viridis"], lambda t: t):
        assert apply_colormap([], colormap, None, 0).shape == (0, 4)


def test_what_lies_far_beyond_narrow_limits_takes_the_colours_of_the_ends() -> None:
    for colormap in ("viridis", matplotlib.colormaps["viridis"]):
        colors = apply_colormap([-1e308, 0.0, 1e-300, 1e308], colormap, (0.0, 1e-300), 4)
        assert (colors == apply_colormap([0.0, 0.0, 1.0, 1.0], "viridis", None, 4)).all()


def grey(places: Array) -> Array:
    return np.column_stack([places] * 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scalars": [1.0] * 11}, "scalars must have one number for each of the 12 points, got 11"),
        ({"scalars": np.ones((12, 1))}, "scalars must have shape (12,), got (12, 1)"),
        ({"scalars": [1.0] * 11 + [np.inf]}, "scalars must be finite or NaN, got inf at index 11"),
        ({"scalars": [np.nan, -np.inf] * 6}, "scalars must be finite or NaN, got -inf at index 1"),
        ({"clim": (2, 1)}, "clim must be (low, high), got (2, 1); a cmap ending in '_r' is reversed"),
        ({"clim": (1, 2, 3)}, "clim must have shape (2,), got (3,)"),
        ({"clim": (0, np.nan)}, "clim must be finite, got nan at index 1"),
        (
            {"cmap": "virdis"},
            "cmap must be a colormap's name, such as 'viridis', got 'virdis'; did you mean 'viridis'?",
        ),
        ({"cmap": ""}, "cmap must be a colormap's name, such as 'viridis', got ''"),
        ({"cmap": "_r"}, "cmap must be a colormap's name, such as 'viridis', got '_r'"),
        (
            {"cmap": "viridis_r_r"},
            "cmap must be a colormap's name, such as 'viridis', got 'viridis_r_r'; did you mean 'viridis'?",
        ),
        ({"cmap": lambda t: grey(t)[1:]}, "the colours from cmap must have one row for each of the 12 points, got 11"),
        ({"cmap": lambda t: t}, "the colours from cmap must have shape (12, 3) or (12, 4), got (12,)"),
        (
            {"cmap": lambda t: grey(t) * 255},
            "the colours from cmap must hold numbers from 0 to 1, or uint8, got 23.1818 at index (1, 0)",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_cannot_be_mapped_is_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        apply_colormap(**{"scalars": np.arange(12.0), "cmap": "viridis", "clim": None, **arguments}, n_points=12)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("scalars", "colormap", "message"),
    [
        (["a"] * 12, "viridis", "scalars must hold real numbers, got dtype <U1"),
        ([True] * 12, "viridis", "scalars must hold real numbers, got dtype bool"),
        ([0.0] * 12, None, "cmap must be a colormap's name or a callable, got NoneType"),
        ([0.0] * 12, [(0, 0, 0), (1, 1, 1)], "cmap must be a colormap's name or a callable, got list"),
    ],
)
def test_what_is_of_another_type_is_refused_by_type(scalars: Any, colormap: Callable[..., Any], message: str) -> None:
    with pytest.raises(ArgumentTypeError) as caught:
        apply_colormap(scalars, colormap, None, 12)
    assert str(caught.value) == message
