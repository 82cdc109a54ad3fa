"""Headless Chromium, driven by Selenium, in which tests open pages."""

import base64
import io
import os
import shutil
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image
from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"),
    *("--force-device-scale-factor=1", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic"),
    # Without a network, pages that need one must fail here too.
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)

NO_GPU_FLAGS = ("--disable-gpu",)  # with which a page loses its WebGPU device as soon as a canvas shows a picture

WEBGPU_FLAGS = (
    *("--enable-unsafe-webgpu", "--enable-features=Vulkan", "--use-vulkan=swiftshader", "--use-angle=swiftshader"),
)

POLL = """
const [milliseconds, done] = arguments, end = performance.now() + milliseconds;
(function look() {
    if (%s) done(true);
    else if (performance.now() > end) done(false);
    else requestAnimationFrame(look);
})();
"""


class Browser:
    """One window, closed at the end of a `with` block.

    driver : Selenium's own, for what no method does
    webgpu : whether pages can compute on a GPU, by SwiftShader

    Everything that the browser writes goes into a temporary folder.
    """

    def __init__(self, *, webgpu: bool = False) -> None:
        chromedriver = shutil.which("chromedriver")
        if chromedriver is None:
            raise RuntimeError(
                "chromedriver is not installed: 'make browser' installs it with Chromium, or says what to do"
            )
        options = Options()
        for flag in FLAGS + (WEBGPU_FLAGS if webgpu else NO_GPU_FLAGS):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "WARNING"})
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        service = Service(chromedriver, env={**os.environ, "TMPDIR": self._folder.name})
        self.driver = webdriver.Chrome(options, service)
        transparent = {"color": {"r": 0, "g": 0, "b": 0, "a": 0}}
        self.driver.execute_cdp_cmd("Emulation.setDefaultBackgroundColorOverride", transparent)

    def open(self, page: Path, size: tuple[int, int]) -> None:
        """Load a file, HTML or SVG, in a window of `size`, and clear the console."""
        width, height = size
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.console_messages()
        self.driver.get(page.resolve().as_uri())

    def screenshot(self) -> npt.NDArray[np.uint8]:
        """Return the window (height, width, 4), straight alpha: 0 where the page paints nothing."""
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
        with Image.open(io.BytesIO(base64.b64decode(shot["data"]))) as image:
            return np.asarray(image.convert("RGBA"))

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression in the page."""
        return self.driver.execute_script(f"return {expression}")

    def wait_for(self, expression: str, seconds: float = 10.0) -> None:
        """Wait until a JavaScript expression is true in the page; raise `TimeoutException` if it stays false.

        The page evaluates it before each frame that it paints, so a state that lasts for one frame is not missed.
        """
        self.driver.set_script_timeout(seconds + 60.0)
        if not self.driver.execute_async_script(POLL % expression, 1000.0 * seconds):
            raise TimeoutException(f"still false: {expression}")

    def click(self, selector: str) -> None:
        """Click the centre of the first element that a CSS selector finds."""
        self.driver.find_element(By.CSS_SELECTOR, selector).click()

    def console_messages(self) -> list[str]:
        """Return the warnings and errors of the page's console since the last call."""
        return [entry["message"] for entry in self.driver.execute("getLog", {"type": "browser"})["value"]]

    def __enter__(self) -> "Browser":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.driver.quit()
        self._folder.cleanup()
