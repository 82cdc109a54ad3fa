"""The lecture's notebook runs, and shows a figure for every section."""

import base64
import io
import re
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image

PAGE = Path(__file__).parents[2] / "docs" / "lecture.ipynb"


def notebook() -> Any:
    read: Any = nbformat.read
    return read(PAGE, as_version=4)


@pytest.fixture(scope="module")
def cells(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    """The cells, after they have run in an empty folder."""
    page = notebook()
    place = str(tmp_path_factory.mktemp("lecture"))
    NotebookClient(page, timeout=300, kernel_name="python3", resources={"metadata": {"path": place}}).execute()
    return list(page.cells)


def test_it_is_kept_without_what_it_shows() -> None:
    page = notebook()
    nbformat.validate(page)
    for cell in page.cells:
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count) == ([], None)


def test_its_contents_lead_to_its_sections() -> None:
    text = "\n".join(cell.source for cell in notebook().cells if cell.cell_type == "markdown")
    titles = re.findall(r"^## (.+)$", text, re.MULTILINE)
    assert [title.split(".")[0] for title in titles] == [str(i) for i in range(1, 15)]
    listed = re.findall(r"^(\d+)\. \[(.+)\]\(#(.+)\)$", text, re.MULTILINE)
    assert [f"{number}. {title}" for number, title, _ in listed] == titles
    assert [anchor for *_, anchor in listed] == [title.replace(" ", "-") for title in titles]


def test_figures_name_their_parts_themselves() -> None:
    code = "\n".join(cell.source for cell in notebook().cells if cell.cell_type == "code")
    assert "labels={0: name}" in code  # the triangles of the eighth figure
    assert 'print(f"{color}: {name}")' not in code
    assert len(re.findall(r"axes=(?:\(|chart_axes)", code)) >= 2


def outputs(cells: list[Any], kind: str) -> dict[int, list[str]]:
    """Return what the cells of each section put out in one MIME type, "" for what is printed."""
    section, found = 0, dict[int, list[str]]()
    for cell in cells:
        if cell.cell_type == "markdown" and (title := re.match(r"## (\d+)\.", cell.source)):
            section = int(title[1])
        for output in cell.get("outputs", []):
            assert output.get("name") != "stderr", output.text
            content = output.get("text") if kind == "" else output.get("data", {}).get(kind)
            if content:
                found.setdefault(section, []).append(content)
    return found


@pytest.mark.slow  # runs the notebook
def test_every_figure_is_drawn(cells: list[Any]) -> None:
    pictures = {
        section: np.asarray(Image.open(io.BytesIO(base64.b64decode(data[0]))).convert("RGB"))
        for section, data in outputs(cells, "image/png").items()
    }
    sizes = {section: (picture.shape[1], picture.shape[0]) for section, picture in pictures.items()}
    assert sizes == {
        1: (480, 288),
        2: (320, 320),
        3: (400, 400),
        6: (780, 520),
        7: (600, 360),
        8: (500, 430),
        10: (640, 360),
        11: (500, 370),
        12: (600, 180),
    }
    for section, picture in pictures.items():
        ink = (picture < 128).any(axis=2)
        assert 0.005 < ink.mean() < 0.25, section
    # Where the projection comes last, red lies along one row; where it comes first, it rises to sin 30 degrees.
    order = np.asarray(Image.open(io.BytesIO(base64.b64decode(outputs(cells, "image/png")[8][1]))).convert("RGB"))
    red = (np.abs(order - np.array([214.0, 39, 40])) < 40).all(axis=2)
    heights = [np.ptp(np.flatnonzero(half.any(axis=1))) / order.shape[0] * 2.8 for half in np.hsplit(red, 2)]
    assert heights == pytest.approx([0, 0.5], abs=0.05)
    assert_first_section(outputs(cells, "image/png")[1])
    # The four triangles of the eighth figure, each in its own colour.
    for color in ("blue", "red", "green", "orange"):
        rgb = np.array(Image.new("RGB", (1, 1), color).getpixel((0, 0)))
        assert np.count_nonzero((pictures[8] == rgb).all(axis=2)) > 50, color


def assert_first_section(data: list[str]) -> None:
    """A curve, a patch, four teapots side by side, and what is measured below what is promised."""
    pictures = [np.asarray(Image.open(io.BytesIO(base64.b64decode(each))).convert("RGB")) for each in data]
    assert [picture.shape[1::-1] for picture in pictures] == [(480, 288), (480, 360), (1120, 208), (384, 384)]
    columns = (pictures[2] < 128).any(axis=(0, 2))
    assert np.count_nonzero(np.diff(columns.astype(np.int8)) == 1) == 4
    chart = pictures[3].astype(int)
    red = np.abs(chart - [214, 39, 40]).max(axis=2) < 60
    grey = np.abs(chart - 127).max(axis=2) < 30
    both = np.flatnonzero(red.any(axis=0) & grey.any(axis=0))
    assert len(both) > 250
    assert all(np.flatnonzero(red[:, x]).mean() > np.flatnonzero(grey[:, x]).mean() for x in both)


@pytest.mark.slow  # runs the notebook
def test_every_animation_has_its_frames(cells: list[Any]) -> None:
    shown = outputs(cells, "text/html")
    assert {section: len(players) for section, players in shown.items()} == {4: 1, 9: 1, 10: 1, 13: 1, 14: 1}
    text = outputs(cells, "text/plain")
    assert text[4] == ["<Animation: 100 frames of 320 x 320, 10 a second>"]
    assert text[9] == ["<Animation: 100 frames of 320 x 320, 10 a second>"]
    assert text[10][1:] == ["<Animation: 60 frames of 400 x 320, 20 a second>"]
    assert text[13] == ["<Animation: 25 frames of 320 x 260, 20 a second>"]
    assert text[14] == ["<Animation: 25 frames of 320 x 320, 20 a second>"]


@pytest.mark.slow  # runs the notebook
def test_what_is_printed_is_what_the_lecture_says(cells: list[Any]) -> None:
    printed = {section: "".join(texts) for section, texts in outputs(cells, "").items()}
    assert "within  0.1:   1177 points,   1152 faces" in printed[1]
    assert printed[1].count("times less") == 9
    assert printed[2].count("\nf ") == 7
    assert "faces of [5, 4] corners" in printed[2]
    assert "divided by w  [ 2  4  0  1   ]" in printed[7]
    assert "after M3  [ -0.8  2    1 ]" in printed[8]
    assert "24 nodes show 1 model" in printed[10]
    toeplitz = [[2, 1, 0, 0, 0], [3, 2, 1, 0, 0], [0, 3, 2, 1, 0], [0, 0, 3, 2, 1], [0, 0, 0, 3, 2]]
    assert [float(number) for number in re.findall(r"[\d.]+", printed[11])] == np.ravel(toeplitz).tolist()
    assert printed[12] == "omega = 50.00/s; of the steps 51.57/s\n"
    assert "largest step 0.86 ms" in printed[13]
