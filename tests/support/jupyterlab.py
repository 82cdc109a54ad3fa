"""A JupyterLab with a notebook, for tests that open it in a browser."""

import base64
import contextlib
import io
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import Any

import nbformat
from PIL import Image
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.support.browser import Browser

NAME = "notebook.ipynb"
START_S = 120.0
CELL_S = 30.0
FOCUS_S = 0.3  # after which a widget of rendercanvas that was clicked takes keys
OPTIONS = ("--no-browser", "--allow-root", "--ServerApp.ip=127.0.0.1", "--IdentityProvider.token=")
NO_NEWS = '{"@jupyterlab/apputils-extension:notification": {"fetchNews": "false"}}'


class JupyterLab:
    """A server with one notebook of code cells, closed at the end of a `with` block."""

    def __init__(self, cells: Sequence[str]) -> None:
        self._temporary = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        folder = Path(self._temporary.name)
        v4: Any = nbformat.v4
        write: Any = nbformat.write
        kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
        book = v4.new_notebook(cells=[v4.new_code_cell(code) for code in cells], metadata={"kernelspec": kernel})
        self.folder = folder / "notebooks"
        self.folder.mkdir()
        write(book, self.folder / NAME)
        overrides = folder / "lab" / "settings"
        overrides.mkdir(parents=True)
        (overrides / "overrides.json").write_text(NO_NEWS)
        places = {name: str(folder / name) for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")}
        kept = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        options = (*OPTIONS, f"--ServerApp.port={self.port}", f"--ServerApp.root_dir={self.folder}")
        with (folder / "log.txt").open("wb") as log:
            self._server = subprocess.Popen(
                [sys.executable, "-m", "jupyterlab", *options, f"--LabApp.app_settings_dir={overrides}"],
                env={**kept, **places},
                cwd=folder,
                stdout=log,
                stderr=log,
            )
        self._log = folder / "log.txt"

    def open(self, browser: Browser, size: tuple[int, int]) -> None:
        """Show the notebook in a browser, once the server answers."""
        end = time.monotonic() + START_S
        while True:
            try:
                urllib.request.urlopen(f"http://127.0.0.1:{self.port}/api/status", timeout=2.0).close()
                break
            except OSError as error:
                if self._server.poll() is not None or time.monotonic() > end:
                    raise RuntimeError(self._log.read_text("utf-8")) from error
                time.sleep(0.2)
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        browser.driver.get(f"http://127.0.0.1:{self.port}/lab/tree/{NAME}")
        browser.wait_for("document.querySelector('.jp-CodeCell .cm-content')", START_S)
        browser.wait_for("document.querySelector('.jp-NotebookPanel [data-status=idle]')", START_S)  # the kernel

    def run_cell(self, browser: Browser, k: int) -> WebElement:
        """Run a cell as Shift+Enter does; return it, once it has its number and an output."""
        cell = f"document.querySelectorAll('.jp-CodeCell')[{k}]"
        prompt = f"{cell}.querySelector('.jp-InputPrompt').innerText"
        is_started = False
        end = time.monotonic() + CELL_S
        while not is_started and time.monotonic() < end:  # a lab that is not ready loses keys
            element = self.enter_cell(browser, k)
            ActionChains(browser.driver).key_down(Keys.SHIFT).send_keys(Keys.ENTER).key_up(Keys.SHIFT).perform()
            with contextlib.suppress(TimeoutException):
                browser.wait_for(f"/[*\\d]/.test({prompt})", 2.0)
                is_started = True
        browser.wait_for(f"/\\d/.test({prompt})", CELL_S)
        browser.wait_for(f"{cell}.querySelector('.jp-OutputArea-output')", CELL_S)
        return element

    def convert(self, browser: Browser, k: int) -> list[Image.Image]:
        """Save the notebook, whose cell has run, as Ctrl+S does; return the cell's pictures of nbconvert's HTML."""
        nbconvert: Any = import_module("nbconvert")  # comes with JupyterLab
        self.enter_cell(browser, k)
        ActionChains(browser.driver).key_down(Keys.CONTROL).send_keys("s").key_up(Keys.CONTROL).perform()
        read: Any = nbformat.read
        end = time.monotonic() + CELL_S
        while not (cell := read(self.folder / NAME, as_version=4).cells[k]).outputs and time.monotonic() < end:
            time.sleep(0.2)
        v4: Any = nbformat.v4
        page, _ = nbconvert.HTMLExporter().from_notebook_node(v4.new_notebook(cells=[cell]))
        pictures = re.findall(r'<img[^>]*src="data:image/png;base64,([^"]+)"', page)
        return [Image.open(io.BytesIO(base64.b64decode(picture))) for picture in pictures]

    def enter_cell(self, browser: Browser, k: int) -> WebElement:
        """Give the keys to the code of a cell, and return the cell."""
        element = browser.driver.find_elements(By.CSS_SELECTOR, ".jp-CodeCell")[k]
        browser.driver.execute_script(
            "arguments[0].scrollIntoView(); arguments[0].querySelector('.cm-content').focus()", element
        )
        return element

    def __enter__(self) -> "JupyterLab":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._server.terminate()
        self._server.wait(30.0)
        self._temporary.cleanup()
