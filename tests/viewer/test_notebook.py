"""The viewer in a notebook: a widget that a real kernel draws, without a display."""

import base64
import io
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image

import gpu_xform as gx
from gpu_xform import MissingExtraError
from gpu_xform.viewer import notebook
from gpu_xform.viewer.session import Session

SHOW = """
import gpu_xform as gx
import numpy as np
from rendercanvas.anywidget import RenderCanvas

made = []
whole = RenderCanvas.__init__

def remember(self, *args, **kwargs):
    whole(self, *args, **kwargs)
    made.append(self)

RenderCanvas.__init__ = remember
frames = []
RenderCanvas._rc_present_bitmap = lambda self, *, data, format, **_: frames.append(np.array(data))
net = gx.Springs(gx.samples.cloth(6, 6), mass=0.1, stretch=100, shear=10, bend=1, pinned=[0, 6])
gx.view(net, size=(200, 160))
"""

DRAG = """
import asyncio

[canvas] = made
canvas._has_visible_views = True
canvas._rfb_handle_msg(canvas, {"type": "resize", "pwidth": 200, "pheight": 160, "ratio": 1.0}, [])
canvas.force_draw()
canvas._rfb_handle_msg(canvas, {"type": "key_down", "timestamp": 1.0, "key": " ", "modifiers": []}, [])
for _ in range(20):
    await asyncio.sleep(0.05)
    canvas.force_draw()
shown = [frame for frame in frames if frame.shape == (160, 200, 4)]
print(len(shown) > 2, bool((shown[0] != shown[-1]).any()), net.time > 0.0)
"""

CLOSE = """
canvas._rfb_handle_msg(canvas, {"type": "key_down", "timestamp": 2.0, "key": "q", "modifiers": []}, [])
for _ in range(20):
    await asyncio.sleep(0.05)
print(canvas.get_closed())
"""


def test_a_kernel_shows_a_widget_and_simulates_in_it_until_a_key_closes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    v4: Any = nbformat.v4
    cells = [v4.new_code_cell(code) for code in (SHOW, DRAG, CLOSE)]
    book = v4.new_notebook(cells=cells)
    NotebookClient(book, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    [data] = [output["data"] for output in book.cells[0].outputs if "data" in output]
    assert "application/vnd.jupyter.widget-view+json" in data
    assert_still(data)
    states = book.metadata["widgets"]["application/vnd.jupyter.widget-state+json"]["state"].values()
    [script] = [each["state"]["_esm"] for each in states if "_esm" in each["state"]]
    assert data["image/png"].strip() in script  # where the state is kept, a page shows the widget
    printed = "".join(output["text"] for cell in book.cells[1:] for output in cell.outputs if "text" in output)
    assert printed.split() == ["True"] * 4  # on standard error too, where rendercanvas writes what failed


def assert_still(data: dict[str, Any]) -> None:
    """What a page or a reader without a kernel shows: a picture as the widget first shows it."""
    with Image.open(io.BytesIO(base64.b64decode(data["image/png"]))) as still:
        assert still.size == (200, 160)
        assert 0.05 < (np.asarray(still.convert("L")) < 128).mean() < 0.5
    assert data["text/plain"].startswith("<view of ")


@pytest.mark.parametrize(("size", "expected"), [((1280, 960), (640, 480)), ((300, 2000), (96, 640)), ((8, 6), (8, 6))])
def test_the_picture_that_stays_is_no_larger_than_a_page_needs(
    size: tuple[int, int], expected: tuple[int, int]
) -> None:
    session = Session(gx.samples.cube(), None, None, size, "white", None, "auto", {})
    with Image.open(io.BytesIO(notebook._draw_still(session, size))) as still:
        assert still.size == expected


def test_without_the_extra_the_error_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu_xform.viewer.window.is_in_notebook", lambda: True)
    monkeypatch.setitem(__import__("sys").modules, "rendercanvas.anywidget", None)
    with pytest.raises(MissingExtraError, match=r"anywidget: pip install 'gpu_xform\[notebook\]'"):
        gx.view(gx.samples.cube())


def test_a_script_is_no_notebook() -> None:
    assert not notebook.is_in_notebook()
