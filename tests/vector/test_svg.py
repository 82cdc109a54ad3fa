"""The text of an SVG, read by an XML parser."""

import dataclasses
import re
import xml.etree.ElementTree as ET
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.vector import Points, Polygons, Stroke, VectorLayer, format_svg
from gpu_xform.vector.join_segments import MAX_POINTS_PER_LINE

WHITE = (1.0, 1.0, 1.0, 1.0)
SVG = "{http://www.w3.org/2000/svg}"
CLASSES = ("faces", "hidden", "visible", "points")


def make_layer(segments: npt.ArrayLike, **others: Any) -> VectorLayer:
    array = np.array(segments, np.float32).reshape(-1, 4)
    n = len(array)
    black = np.array([[0.0, 0.0, 0.0, 1.0]])
    solid, dashed = Stroke(1.5, ()), Stroke(1.5, (6.0, 4.5))
    made = VectorLayer("model", array, np.zeros(n, np.bool_), np.zeros(n), black, solid, dashed)
    return dataclasses.replace(made, **others)


def parsed(*layers: VectorLayer, background: Any = WHITE) -> ET.Element:
    return ET.fromstring(format_svg((640, 480), background, layers))  # noqa: S314 - our own


def group(root: ET.Element, name: str) -> ET.Element:
    [found] = root.findall(f".//{SVG}g[@class='{name}']")
    return found


def lines(path: ET.Element) -> list[list[tuple[float, float]]]:
    """Return the points of each line of a path."""
    data = path.attrib["d"]
    assert re.fullmatch(r"(M-?[\d.]+( -?[\d.]+)*z?)+", data)
    numbers = [list(map(float, line.strip("z").split())) for line in data.split("M")[1:]]
    return [list(zip(line[::2], line[1::2], strict=True)) for line in numbers]


def find_segments(element: ET.Element) -> npt.NDArray[np.float64]:
    """Return the segments of all paths, sorted, whichever way they run."""
    segments = [sorted(pair) for path in element for line in lines(path) for pair in pairwise(line)]
    return np.array(sorted(segments)).reshape(-1, 4)


def test_a_picture_has_its_size_its_background_and_its_models() -> None:
    root = parsed(make_layer([1, 2, 3, 4]), make_layer([5, 6, 7, 8], name="other"), background=(1.0, 0.5, 0.0, 0.2))
    assert root.tag == f"{SVG}svg"
    assert root.attrib == {"width": "640", "height": "480", "viewBox": "0 0 640 480"}
    background, *models = root
    paint = {"fill": "#ff8000", "fill-opacity": "0.2"}
    assert background.attrib == {"id": "background", "width": "640", "height": "480", **paint}
    assert [model.attrib for model in models] == [{"id": "model"}, {"id": "other"}]
    assert [model.findtext(f"{SVG}title") for model in models] == ["model", "other"]


def test_a_transparent_background_is_none() -> None:
    assert [child.tag for child in parsed(make_layer([]), background=(1.0, 1.0, 1.0, 0.0))] == [f"{SVG}g"]


COORDINATES = st.floats(-1e5, 1e5, width=32)


def drop_covered_dots(segments: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the segments (n, 4) without those of no length where a longer one has an end, which covers them."""
    is_dot = (segments[:, :2] == segments[:, 2:]).all(axis=1)
    ends = {tuple(end) for end in segments[~is_dot].reshape(-1, 2).tolist()}
    return segments[[not dot or tuple(row[:2]) not in ends for dot, row in zip(is_dot, segments.tolist(), strict=True)]]


@pytest.mark.parametrize(("dot", "is_written"), [((0, 0, 0, 0), False), ((0, 1, 0, 1), False), ((0, 2, 0, 2), True)])
def test_a_segment_of_no_length_is_written_where_no_line_ends(dot: tuple[int, ...], is_written: bool) -> None:
    array = np.array([dot, (0, 0, 0, 1)], np.float32)
    (group,) = parsed(make_layer(array)).findall(f".//{SVG}g[@class='visible']")
    assert (list(dot) in find_segments(group).tolist()) == is_written


@given(st.lists(st.tuples(*[COORDINATES] * 4), max_size=20), st.data())
def test_every_segment_is_there_to_a_hundredth_of_a_pixel(
    segments: list[tuple[float, ...]], data: st.DataObject
) -> None:
    hidden = np.array(data.draw(st.lists(st.booleans(), min_size=len(segments), max_size=len(segments))), np.bool_)
    array = np.array(segments, np.float32).reshape(-1, 4)
    root = parsed(make_layer(array, hidden=hidden))
    for name, chosen in (("hidden", hidden), ("visible", ~hidden)):
        rounded = np.rint(array[chosen].astype(np.float64) * 100) / 100
        expected = sorted(sorted([tuple(row[:2]), tuple(row[2:])]) for row in rounded.tolist())
        groups = root.findall(f".//{SVG}g[@class='{name}']")
        assert len(groups) == (len(expected) > 0)
        for element in groups:
            found = drop_covered_dots(find_segments(element))
            np.testing.assert_array_equal(found, drop_covered_dots(np.array(expected).reshape(-1, 4)))


def test_styles_are_on_the_groups() -> None:
    root = parsed(
        make_layer(
            [[0, 0, 9, 0], [0, 1, 9, 1], [0, 2, 9, 2]],
            hidden=np.array([True, False, False]),
            colors=np.array([[0.2, 0.4, 0.6, 0.4]]),
            visible_stroke=Stroke(2.25, ()),
            hidden_stroke=Stroke(2.25, (9.0, 6.75)),
        )
    )
    common = {"fill": "none", "stroke": "#336699", "stroke-opacity": "0.4", "stroke-width": "2.25"}
    ends = {"stroke-linecap": "round", "stroke-linejoin": "round"}
    assert group(root, "visible").attrib == {"class": "visible", **common, **ends}
    assert group(root, "hidden").attrib == {
        "class": "hidden",
        **common,
        "stroke-linejoin": "round",
        "stroke-dasharray": "9 6.75",
    }
    assert all(set(path.attrib) == {"d"} for name in ("visible", "hidden") for path in group(root, name))


def test_faded_lines_are_lines_like_others() -> None:
    both = make_layer(
        [[0, 0, 9, 0], [9, 0, 9, 9]],
        hidden=np.array([True, True]),
        hidden_stroke=Stroke(1.5, ()),
        dash_start=np.array([3, 5]),
    )
    hidden = group(parsed(both), "hidden")
    assert hidden.attrib["stroke-linecap"] == "round"
    assert "stroke-dasharray" not in hidden.attrib
    assert [path.attrib for path in hidden] == [{"d": "M0 0 9 0 9 9"}]


def test_opaque_neighbours_of_one_colour_share_a_path_and_those_that_meet_a_line() -> None:
    segments = [[0, 0, 9, 0], [50, 50, 60, 60], [9, 0, 9, 9], [9, 9, 30, 1], [1, 1, 2, 2]]
    colors = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [1, 0, 0, 1], [0, 0, 1, 1], [1, 0, 0, 1]])
    paths = group(parsed(make_layer(segments, colors=colors)), "visible")
    assert [path.attrib for path in paths] == [
        {"d": "M0 0 9 0 9 9M50 50 60 60"},
        {"d": "M9 9 30 1", "stroke": "#0000ff"},
        {"d": "M1 1 2 2"},
    ]


def test_transparent_lines_have_paths_of_their_own_so_that_crossings_are_darker() -> None:
    colors = np.array([[0, 0, 0, 0.2], [0, 0, 0, 0.2], [0, 0, 0, 1], [0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0.4]])
    segments = [[i, 0, i + 1, 0] for i in range(6)]
    paths = group(parsed(make_layer(segments, colors=colors)), "visible")
    assert [path.attrib for path in paths] == [
        {"d": "M0 0 1 0"},
        {"d": "M1 0 2 0"},
        {"d": "M2 0 3 0 4 0", "stroke-opacity": "1"},
        {"d": "M5 0 6 0", "stroke-opacity": "0.4"},
    ]


def test_dashed_lines_start_where_their_pattern_says() -> None:
    segments = [[0, 0, 9, 0], [9, 0, 9, 9], [0, 20, 30, 20], [0, 30, 9, 30]]
    starts = np.array([0, 21.0, 12.5, 12.5 + 3 * 10.5])  # the pattern of 1.5 pixels' width is 10.5 long
    hidden = group(parsed(make_layer(segments, hidden=np.ones(4, np.bool_), dash_start=starts)), "hidden")
    assert [path.attrib for path in hidden] == [
        {"d": "M0 0 9 0M9 0 9 9"},
        {"d": "M0 20 30 20M0 30 9 30", "stroke-dashoffset": "2"},
    ]


def test_dashed_lines_of_other_colours_stay_in_their_order() -> None:
    colors = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 0, 1, 1], [1, 0, 0, 0.4], [1, 0, 0, 0.4]])
    segments = [[i, 0, i, 9] for i in range(5)]
    starts = np.array([5, 4, 3, 2, 1])
    hidden = group(
        parsed(make_layer(segments, hidden=np.ones(5, np.bool_), dash_start=starts, colors=colors)), "hidden"
    )
    where = [(path.attrib["d"][1], path.attrib["stroke-dashoffset"]) for path in hidden]
    assert where == [("1", "4"), ("0", "5"), ("2", "3"), ("3", "2"), ("4", "1")]


def test_a_path_is_not_too_long_for_readers_of_xml() -> None:
    n = 2 * MAX_POINTS_PER_LINE
    scattered = np.random.default_rng(0).uniform(0, 640, (n, 4))
    one_line = np.column_stack([np.arange(n), np.zeros(n), np.arange(n) + 1, np.zeros(n)])
    visible = group(parsed(make_layer(np.concatenate([scattered, one_line]))), "visible")
    counts = [[len(line) for line in lines(path)] for path in visible]
    assert sum(points - 1 for path in counts for points in path) == 2 * n
    assert max(map(sum, counts)) <= 2 * MAX_POINTS_PER_LINE
    assert len(counts) <= 3 * n / MAX_POINTS_PER_LINE + 1


def test_polygons_of_one_colour_are_a_path_and_have_one_winding() -> None:
    corners = np.array([[0, 0], [9, 0], [9, 9], [0, 0], [0, 9], [9, 9], [20, 0], [30, 0], [30, 10], [20, 10]])
    polygons = Polygons(np.array([0, 3, 6, 10]), corners, np.array([[1.0, 0.0, 0.0, 0.6]]))
    faces = group(parsed(make_layer([], polygons=polygons)), "faces")
    assert faces.attrib == {"class": "faces", "fill": "#ff0000", "opacity": "0.6"}
    assert [path.attrib for path in faces] == [{"d": "M0 0 9 0 9 9zM9 9 0 9 0 0zM20 0 30 0 30 10 20 10z"}]


def test_polygons_of_several_colours_overlap_a_little_and_one_alpha_is_one_group() -> None:
    corners = np.array([[0, 0], [9, 0], [9, 9]] * 5)
    colors = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 1, 0, 1], [0, 1, 0, 0.2], [0, 1, 0, 0]])
    root = parsed(make_layer([], polygons=Polygons(np.arange(0, 16, 3), corners, colors)))
    opaque, translucent = root.findall(f".//{SVG}g[@class='faces']")
    seam = {"stroke": "#ff0000", "stroke-width": "0.5", "stroke-linejoin": "round"}
    assert opaque.attrib == {"class": "faces", "fill": "#ff0000", **seam}
    once = "M0 0 9 0 9 9z"
    assert [path.attrib for path in opaque] == [{"d": 2 * once}, {"d": once, "fill": "#00ff00", "stroke": "#00ff00"}]
    assert translucent.attrib == {"class": "faces", "fill": "#00ff00", "opacity": "0.2"}
    assert [path.attrib for path in translucent] == [{"d": once}]


def test_points_are_circles() -> None:
    circles = np.array([[1, 2, 3], [4.256, -5, 0.5], [7, 8, 9]])
    colors = np.array([[1, 0, 0, 1], [0, 0, 1, 0.8], [1, 0, 0, 0]])
    points = group(parsed(make_layer([], points=Points(circles, colors))), "points")
    assert points.attrib == {"class": "points", "fill": "#ff0000"}
    assert [circle.attrib for circle in points] == [
        {"cx": "1", "cy": "2", "r": "1.5"},
        {"cx": "4.26", "cy": "-5", "r": "0.25", "fill": "#0000ff", "fill-opacity": "0.8"},
    ]


def test_faces_lie_under_hidden_lines_and_those_under_visible_ones_and_points_on_top() -> None:
    everything = make_layer(
        [[0, 0, 9, 0], [0, 1, 9, 1]],
        hidden=np.array([False, True]),
        polygons=Polygons(np.array([0, 3]), np.eye(3)[:, :2], np.ones((1, 4))),
        points=Points(np.ones((1, 3)), np.ones((1, 4))),
    )
    [_, [_, *groups]] = parsed(everything)
    assert [element.attrib["class"] for element in groups] == list(CLASSES)


def test_what_shows_nothing_is_an_empty_group() -> None:
    nothing = make_layer(
        [],
        polygons=Polygons(np.array([0]), np.zeros((0, 2)), np.ones((1, 4))),
        points=Points(np.zeros((0, 3)), np.zeros((0, 4))),
    )
    unseen = make_layer([0, 0, 9, 9], colors=np.zeros((1, 4)))
    for layer in (nothing, unseen):
        [_, model] = parsed(layer)
        assert [child.tag for child in model] == [f"{SVG}title"]
    assert [child.attrib for child in parsed(background=(0, 0, 0, 0))] == []


@pytest.mark.parametrize(
    ("names", "identifiers"),
    [
        (("house", "house", "house"), ("house", "house-2", "house-3")),
        (("house", "house-2", "house", "house"), ("house", "house-2", "house-3", "house-4")),
        (("", "", "model", "7 cubes"), ("model", "model-2", "model-3", "model-7-cubes")),
        (("Café <&\"'> no. 2", "日本", "background"), ("Cafe-no-2", "model", "background-2")),
        (("_x", "-y-", "a/b.obj"), ("model-_x", "y", "a-b-obj")),
    ],
)
def test_ids_are_made_of_names(names: tuple[str, ...], identifiers: tuple[str, ...]) -> None:
    root = parsed(*(make_layer([], name=name) for name in names))
    assert [model.attrib["id"] for model in root[1:]] == list(identifiers)
    titles = [model.findtext(f"{SVG}title") for model in root[1:]]
    assert titles == [name or None for name in names]


@given(st.lists(st.text(st.characters(exclude_categories=()), max_size=8), max_size=6))
def test_any_names_make_a_document_with_different_ids(names: list[str]) -> None:
    root = parsed(*(make_layer([], name=name) for name in names))
    ids = [element.attrib["id"] for element in root]
    assert len(set(ids)) == len(ids) == len(names) + 1
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", identifier) for identifier in ids)
