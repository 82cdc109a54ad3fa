"""The lecture's notebook, run, so that the site shows it with what it puts out."""

import base64
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient

from .project import ROOT

NOTEBOOK = ROOT / "docs" / "lecture.ipynb"
MAX_FIGURE_BYTES = 1_000_000
TIMEOUT_S = 600


def write_notebook(source: Path) -> None:
    """Run the notebook, and write it with its outputs; raise if a figure is too large for a page."""
    read: Any = nbformat.read
    notebook = read(NOTEBOOK, as_version=4)
    with TemporaryDirectory() as folder:
        settings: Any = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=TIMEOUT_S, kernel_name="python3", resources=settings).execute()
    require_small_figures(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            cell.source = rename_anchors(cell.source)
    write: Any = nbformat.write
    write(notebook, source / "tutorials" / NOTEBOOK.name)


def rename_anchors(text: str) -> str:
    """Return Markdown whose links to titles of the notebook, as Jupyter names them, are those of the site."""
    return re.sub(r"\]\(#([^)]+)\)", lambda link: f"](#{_site_anchor(link[1])})", text)


def _site_anchor(anchor: str) -> str:
    return re.sub(r"[^\w-]", "", anchor.lower())


def require_small_figures(notebook: Any) -> None:
    """Raise `ValueError` if one figure of the notebook takes more than `MAX_FIGURE_BYTES`."""
    for size, cell in measure_figures(notebook):
        if size > MAX_FIGURE_BYTES:
            raise ValueError(f"a figure of {size:,} bytes is larger than {MAX_FIGURE_BYTES:,}: {cell[:80]!r}")


def measure_figures(notebook: Any) -> list[tuple[int, str]]:
    """Return the bytes of each figure, and the code that makes it."""
    figures = []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            for kind, content in output.get("data", {}).items():
                if kind.startswith("image/") and kind != "image/svg+xml":
                    figures.append((len(base64.b64decode(content)), cell.source))
                elif kind in ("text/html", "image/svg+xml"):
                    figures.append((len(content.encode()), cell.source))
    return figures
