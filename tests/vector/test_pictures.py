"""What a browser and a PDF viewer make of the files, beside the exact picture."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pypdfium2
import pytest

from gpu_xform.drawing.dash_patterns import hidden_dashes
from gpu_xform.vector import Points, Polygons, Stroke, VectorLayer, format_pdf, format_svg
from tests.support.browser import Browser
from tests.support.reference_vector import composite_layers

SIZE = (97, 83)
WHITE, NOTHING = (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0)
RANDOM = np.random.default_rng(3)

# Two triangles side by side, one that points another way round, and one over two of them.
CORNERS = np.array(
    [
        [20, 20],
        [80, 30],
        [60, 70],
        [80, 30],
        [90, 80],
        [60, 70],
        [20, 20],
        [60, 70],
        [10, 70],
        [30, 40],
        [60, 60],
        [30, 60],
    ]
)
OUTLINES = np.array([[20, 20, 80, 30], [80, 30, 60, 70], [60, 70, 20, 20], [80, 30, 90, 80], [90, 80, 60, 70]])


def lines(n: int = 12, **others: Any) -> VectorLayer:
    """Return lines of any slope, some of which leave the picture."""
    random = np.random.default_rng(n)
    starts = random.uniform(-5, 100, (n, 2))
    segments = np.hstack([starts, starts + random.normal(scale=25, size=(n, 2))]).astype(np.float32)
    black = np.array([[0.0, 0.0, 0.0, 1.0]])
    layer = VectorLayer("lines", segments, np.zeros(n, np.bool_), np.zeros(n), black, *strokes(1.5))
    return dataclasses.replace(layer, **others)


def strokes(width: float, hidden_dash: tuple[float, ...] | None = None) -> tuple[Stroke, Stroke]:
    """Return how visible and hidden lines are drawn."""
    return Stroke(width, ()), Stroke(width, hidden_dashes(width) if hidden_dash is None else hidden_dash)


def wide(width: float, hidden_dash: tuple[float, ...] | None = None, **others: Any) -> VectorLayer:
    visible, hidden = strokes(width, hidden_dash)
    return lines(visible_stroke=visible, hidden_stroke=hidden, **others)


def faces(*colors: tuple[float, float, float, float]) -> Polygons:
    return Polygons(np.arange(0, 13, 3), CORNERS, np.array(colors))


YELLOW, GREEN, BLUE, RED = (1, 0.8, 0, 1), (0, 0.8, 0, 1), (0, 0.3, 1, 1), (1, 0, 0, 1)
OUTLINE = lines(
    5, segments=OUTLINES, hidden=np.array([True, False, False, False, True]), dash_start=np.array([0, 0, 0, 0, 9.0])
)

PICTURES = {
    "opaque": lines(),
    "wide": wide(4.0),
    "lines that meet": dataclasses.replace(OUTLINE, visible_stroke=Stroke(3.0, ()), hidden_stroke=Stroke(3.0, ())),
    "translucent": wide(3.0, colors=np.array([[0.8, 0.1, 0.0, 0.4]])),
    "colours": wide(4.0, colors=np.hstack([RANDOM.integers(0, 2, (12, 3)), np.ones((12, 1))])),
    "colours and alphas": wide(3.0, colors=RANDOM.uniform(0, 1, (12, 4))),
    "dashed": wide(2.0, hidden=np.ones(12, np.bool_), dash_start=RANDOM.uniform(0, 50, 12)),
    "dashes of narrow lines": wide(1.2, hidden=np.ones(12, np.bool_)),
    "dashed by a pattern": wide(2.0, (6.0, 4.0, 1.0, 4.0, 3.0, 4.0), hidden=np.ones(12, np.bool_)),
    "visible ones dashed": lines(visible_stroke=Stroke(3.0, (9.0, 5.0, 2.0, 5.0))),
    "partly hidden": wide(
        4.0,
        hidden=np.arange(12) % 2 == 0,
        dash_start=RANDOM.uniform(0, 50, 12),
        colors=np.array([BLUE, RED] * 6, np.float64),
    ),
    "visible over hidden": wide(
        14.0,
        (),
        hidden=np.arange(12) % 2 == 1,
        colors=np.array([BLUE, RED] * 6, np.float64),
    ),
    "filled": dataclasses.replace(OUTLINE, polygons=faces(YELLOW)),
    "filled in colours": dataclasses.replace(OUTLINE, polygons=faces(YELLOW, GREEN, BLUE, RED)),
    "filled, translucent": lines(0, polygons=faces((1, 0.8, 0, 0.5))),
    "filled in colours, translucent": lines(
        0, polygons=faces(*((*color[:3], 0.5) for color in (YELLOW, GREEN, BLUE, RED)))
    ),
    "filled in colours and alphas": lines(0, polygons=faces((1, 0.8, 0, 0.5), GREEN, (0, 0.3, 1, 0.0), (1, 0, 0, 0.3))),
    "points": lines(
        0,
        points=Points(
            np.array([[20, 30, 15], [30.5, 33.2, 10], [60.3, 60.7, 3], [80, 20, 7]]),
            np.array([[1, 0, 0, 0.5], [0, 0, 1, 0.9], [0, 0, 0, 1], [0, 0, 0, 0]]),
        ),
    ),
}
STACK = [
    dataclasses.replace(PICTURES["filled"], name="below"),
    dataclasses.replace(PICTURES["wide"], colors=np.array([[0.5, 0, 0.5, 0.6]])),
    PICTURES["points"],
]
CASES = {**{name: [layer] for name, layer in PICTURES.items()}, "several models": STACK}


def shown_in_browser(
    layers: list[VectorLayer], background: Any, browser: Browser, folder: Path
) -> npt.NDArray[np.uint8]:
    page = folder / "picture.svg"
    page.write_text(format_svg(SIZE, background, layers), "utf-8")
    browser.open(page, SIZE)
    return browser.screenshot()


def shown_by_pdfium(layers: list[VectorLayer], background: Any) -> npt.NDArray[np.uint8]:
    [page] = pypdfium2.PdfDocument(format_pdf(SIZE, background, layers))
    bitmap = page.render(scale=96 / 72, fill_color=(0, 0, 0, 0), force_bitmap_format=pypdfium2.raw.FPDFBitmap_BGRA)
    return np.asarray(bitmap.to_numpy()[..., [2, 1, 0, 3]])


def errors(shown: npt.NDArray[np.uint8], exact: npt.NDArray[np.float64], background: Any) -> tuple[float, float]:
    """Return the mean difference, of 255, over the whole picture, and over the pixels that are not background."""
    assert shown.shape == (SIZE[1], SIZE[0], 4)
    premultiplied = shown / 255.0
    premultiplied[..., :3] *= premultiplied[..., 3:]
    backdrop = np.array(background) * background[3]
    touched = ((exact != backdrop) | (premultiplied != backdrop)).any(axis=2)
    difference = 255.0 * np.abs(premultiplied - exact)
    assert 0.02 < touched.mean() < 0.98
    return float(difference.mean()), float(difference[touched].mean())


@pytest.mark.parametrize("background", [WHITE, NOTHING], ids=["white", "transparent"])
@pytest.mark.parametrize("case", CASES)
def test_a_picture_is_as_computed(case: str, background: Any, browser: Browser, tmp_path: Path) -> None:
    exact = composite_layers(SIZE, background, CASES[case])
    for shown in (
        shown_in_browser(CASES[case], background, browser, tmp_path),
        shown_by_pdfium(CASES[case], background),
    ):
        of_picture, of_touched = errors(shown, exact, background)
        assert of_picture <= 3.0
        assert of_touched <= 5.0


def test_nothing_glimmers_between_neighbours(browser: Browser, tmp_path: Path) -> None:
    n, random = 8, np.random.default_rng(8)
    grid = np.stack(np.meshgrid(np.linspace(-5, 105, n), np.linspace(-5, 90, n)), axis=-1).reshape(-1, 2)
    grid = grid + random.uniform(-4, 4, grid.shape)
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = (corner.ravel() for corner in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = random.permutation(np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, c, d])]))
    triangles = np.array([np.roll(triangle, i % 3) for i, triangle in enumerate(triangles)])
    blacks = np.array([[0.0, 0.0, 0.0, 1.0], [0.02, 0.0, 0.0, 1.0]])[random.integers(0, 2, len(triangles))]
    polygons = Polygons(np.arange(0, 3 * len(triangles) + 1, 3), grid[triangles].reshape(-1, 2), blacks)
    layers = [lines(0, polygons=polygons)]
    for shown in (shown_in_browser(layers, WHITE, browser, tmp_path), shown_by_pdfium(layers, WHITE)):
        assert shown[..., :3].max() <= 32  # 84 without the overlap
