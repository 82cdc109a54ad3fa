"""Sheets of views: one scale, aligned, arranged as the projection says, the same in pixels and in vectors."""

import re
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Mesh, samples
from gpu_xform.drawing.sheet import SheetView, lay_out_sheet
from gpu_xform.errors import ArgumentError
from tests.support.types import Array

SIZE = (240, 200)
WEDGE = Mesh([(0, 0, 0), (6, 0, 0), (6, 0, 4), (0, 0, 4), (0, 3, 0), (0, 3, 4)],
             [(0, 1, 2, 3), (0, 4, 1), (3, 2, 5), (0, 3, 5, 4), (1, 4, 5, 2)])  # fmt: skip
NAMES = ("front", "top", "right", "left", "bottom", "back", "iso")


def lay_out(names: tuple[str, ...] = NAMES, up: Any = (0, 1, 0), *, third: bool = True) -> dict[str, SheetView]:
    return {v.name: v for v in lay_out_sheet(WEDGE.positions, names, SIZE, up, is_third_angle=third)}


def on_sheet(view: SheetView, points: Array) -> Array:
    """Return where points of the world are on the sheet, in pixels."""
    clip = np.column_stack([points, np.ones(len(points))]) @ view.camera.clip_from_world(view.size[0] / view.size[1]).T
    ndc = clip[:, :2] / clip[:, 3:]
    pixels: Array = np.array(view.origin) + (ndc * (0.5, -0.5) + 0.5) * view.size
    return pixels


def test_views_are_aligned_and_at_one_scale() -> None:
    at = {name: on_sheet(view, WEDGE.positions) for name, view in lay_out().items()}
    for name in ("top", "bottom"):
        np.testing.assert_allclose(at[name][:, 0], at["front"][:, 0], atol=1e-4)
    for name in ("right", "left", "back"):
        np.testing.assert_allclose(at[name][:, 1], at["front"][:, 1], atol=1e-4)
    px = np.ptp(at["front"][:, 0]) / 6
    assert np.ptp(at["front"][:, 1]) == pytest.approx(3 * px, rel=1e-5)
    np.testing.assert_allclose([np.ptp(at["right"][:, 0]), np.ptp(at["top"][:, 1])], 4 * px, rtol=1e-5)
    edge = np.linalg.norm(at["iso"][1] - at["iso"][0])
    assert edge == pytest.approx(6 * px * np.sqrt(2 / 3), rel=1e-5)  # isometric: all axes are shortened alike
    assert all((points > 0).all() and (points < SIZE).all() for points in at.values())


def test_the_angle_of_projection_says_on_which_side_a_view_lies() -> None:
    third, first = lay_out(third=True), lay_out(third=False)
    middle = {True: {n: on_sheet(v, WEDGE.positions).mean(axis=0) for n, v in third.items()},
              False: {n: on_sheet(v, WEDGE.positions).mean(axis=0) for n, v in first.items()}}  # fmt: skip
    for is_third, m in middle.items():
        assert (m["top"][1] < m["front"][1]) == is_third
        assert (m["bottom"][1] > m["front"][1]) == is_third
        assert (m["right"][0] > m["front"][0]) == is_third
        assert (m["left"][0] < m["front"][0]) == is_third
    # Seen from the right, the front (+z) is at the left; seen from above, it is below.
    depth = np.array([(3.0, 1, 0), (3, 1, 4)])
    right, top = on_sheet(third["right"], depth), on_sheet(third["top"], depth)
    assert right[1, 0] < right[0, 0]
    assert top[1, 1] > top[0, 1]


def test_the_up_direction_turns_all_views() -> None:
    turned = gx.rotate_x(90, degrees=True)  # +y to +z
    views = {v.name: v for v in lay_out_sheet((WEDGE.positions @ turned[:3, :3].T), NAMES, SIZE, (0, 0, 1),
                                              is_third_angle=True)}  # fmt: skip
    for name, view in lay_out().items():
        np.testing.assert_allclose(
            on_sheet(views[name], WEDGE.positions @ turned[:3, :3].T), on_sheet(view, WEDGE.positions), atol=1e-4
        )


def test_a_picture_holds_what_each_view_shows() -> None:
    pixels = gx.render_array(WEDGE, views="front,top,right,iso", size=SIZE, hidden="remove")
    for view in lay_out(("front", "top", "right", "iso")).values():
        (x, y), (w, h) = view.origin, view.size
        alone = gx.render_array(WEDGE, camera=view.camera, size=view.size, hidden="remove")
        np.testing.assert_array_equal(pixels[y : y + h, x : x + w], alone)
    svg = gx.render_svg(WEDGE, views=["front", "top", "right", "iso"], size=SIZE, hidden="remove", name="wedge")
    assert re.findall(r"<title>(.*?)</title>", svg) == [f"{n}: wedge" for n in ("front", "top", "right", "iso")]
    assert gx.render_pdf(WEDGE, views=["front", "iso"], size=SIZE).startswith(b"%PDF")


def test_labels_are_at_their_points_in_each_view_and_keys_stand_once_beside_all() -> None:
    style: dict[str, Any] = {"views": "front,top", "size": SIZE, "name": "wedge", "scalars": [0, 1, 2, 3, 4, 5]}
    style |= {"labels": {1: "tip"}, "legend": True, "colorbar": "height", "font_size": 9}
    svg = gx.render_svg(WEDGE, **style)
    texts = re.findall(r"<text[^>]*?>(.*?)</text>", svg)
    assert texts.count("tip") == 2
    assert texts.count("height") == texts.count("wedge") == 1
    plain = gx.render_array(WEDGE, **style | {"labels": None, "legend": False, "colorbar": False})
    pixels = gx.render_array(WEDGE, **style | {"labels": None})
    column = (pixels[:, -60:, :3] < 255).any(axis=(0, 2))
    assert column.any()
    assert not (pixels != plain).all()
    at = {tuple(np.argwhere((image[..., :3] < 250).any(axis=2)).min(axis=0) > 0) for image in (plain, pixels)}
    assert at == {(True, True)}  # no view is cut off
    labelled = gx.render_array(WEDGE, **style)
    rows = np.flatnonzero((labelled != pixels).any(axis=(1, 2)))
    assert np.diff(rows).max() > 9  # a label above, and one below
    with pytest.raises(ArgumentError, match="paper must not be given with axes, a legend or a colour bar"):
        gx.render_svg(WEDGE, **{k: v for k, v in style.items() if k != "size"}, paper="A6")


def test_sheets_of_paper_are_true_to_scale() -> None:
    views: dict[str, Any] = {"views": "front,top", "paper": "A6", "drawing_scale": "5:1"}
    svg = gx.render_svg(WEDGE, **views)
    assert "105mm" in svg
    pixels = np.asarray(gx.render(WEDGE, **views, dpi=127).convert("L"))  # 5 pixels per millimetre
    columns = np.flatnonzero((pixels < 128).any(axis=0))
    assert columns[-1] - columns[0] == pytest.approx(6 * 5 * 5, abs=3)
    with pytest.raises(ArgumentError, match="paper must have room for all views"):
        gx.render_svg(WEDGE, views="front,top", paper="A6", drawing_scale="50:1")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"views": "front,side"}, "views must be names among front, back, left, right, top, bottom, iso, got 'side'"),
        ({"views": []}, "views must be names among"),
        ({"views": "iso,iso"}, "views must name each view once"),
        ({"views": "iso", "projection": "second"}, "projection must be 'third' or 'first', got 'second'"),
        ({"views": "iso", "camera": {"direction": (0, 0, -1)}}, "camera must be None or hold nothing but 'up'"),
        ({"views": "iso", "axes": True}, "views cannot go with axes: their numbers"),
        ({"views": "front,iso", "size": (2, 2)}, "size must have room for the views"),
    ],
)
def test_what_cannot_be_is_said(arguments: dict[str, Any], message: str) -> None:
    for draw in (gx.render, gx.render_svg):
        with pytest.raises(ArgumentError, match=re.escape(message)):
            draw(samples.cube(), **arguments)
