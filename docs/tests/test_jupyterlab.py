"""The library in a real JupyterLab, in a browser: `make test-docs` runs this."""

import io
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.support.browser import Browser
from tests.support.jupyterlab import CELL_S, FOCUS_S, JupyterLab

WINDOW = (1200, 900)
START = """import gpu_xform as gx
ball = gx.samples.icosphere(2)
scene = gx.Scene()
scene.add(ball, name="ball")
layers = [gx.Layer(ball, color="red"), gx.Layer(gx.samples.cube(), color="blue")]
camera = gx.Camera.look_at((3, 2, 5), (0, 0, 0), near=1, far=10)
ball"""
VIEW = "gx.view(gx.samples.cube(), hidden='remove', size=(320, 240))"
ANIMATION = "gx.turntable(ball, 8, size=(160, 120))"
TYPED = "gx.render(ball, line_w"
CELLS = [START, "scene", "layers", "camera", "gx.render_svg(ball, size=(320, 240))", VIEW, ANIMATION, TYPED]
PICTURED = range(5)
VIEW_CELL, ANIMATION_CELL, TYPED_CELL = range(5, 8)


@pytest.fixture(scope="module")
def opened() -> Iterator[tuple[Browser, JupyterLab]]:
    with JupyterLab(CELLS) as lab, Browser() as browser:
        lab.open(browser, WINDOW)
        lab.run_cell(browser, 0)
        yield browser, lab


def picture_of(element: WebElement) -> np.ndarray[Any, Any]:
    with Image.open(io.BytesIO(element.screenshot_as_png)) as image:
        return np.asarray(image.convert("RGB"))


@pytest.mark.parametrize("k", PICTURED, ids=["mesh", "scene", "layers", "camera", "svg"])
def test_a_model_shows_one_picture_of_itself(k: int, opened: tuple[Browser, JupyterLab]) -> None:
    browser, lab = opened
    [image] = lab.run_cell(browser, k).find_elements(By.CSS_SELECTOR, ".jp-OutputArea-output img")
    shown = picture_of(image)
    assert shown.shape == (240, 320, 3)
    assert 0.005 < (shown < 128).any(axis=2).mean() < 0.3


def test_a_view_is_dragged_and_takes_keys(opened: tuple[Browser, JupyterLab]) -> None:
    browser, lab = opened
    cell = lab.run_cell(browser, VIEW_CELL)
    drawn = "document.querySelector('img.renderview-view').naturalWidth > 100"
    browser.wait_for(f"document.querySelector('img.renderview-view') && {drawn}", CELL_S)
    [view] = cell.find_elements(By.CSS_SELECTOR, "img.renderview-view")
    time.sleep(1.0)  # the first picture is followed by one without loss
    before = picture_of(view)
    actions = ActionChains(browser.driver)
    actions.move_to_element(view).click_and_hold().move_by_offset(60, 20).pause(0.2).move_by_offset(40, 10).release()
    actions.pause(FOCUS_S).perform()
    time.sleep(1.0)
    after = picture_of(view)
    assert (before != after).any(axis=2).mean() > 0.05
    for key, title in (("e", "edges: feature"), ("d", "hidden edges: dash"), (Keys.BACKSPACE, "gpu-xform")):
        ActionChains(browser.driver).send_keys(key).perform()
        browser.wait_for(f"document.querySelector('.renderview-title').innerText.includes('{title}')")
    ActionChains(browser.driver).send_keys("q").perform()
    browser.wait_for("!document.querySelector('img.renderview-view')", CELL_S)
    assert "Error" not in cell.text


def test_a_page_made_of_the_saved_notebook_shows_the_view_as_a_picture(opened: tuple[Browser, JupyterLab]) -> None:
    browser, lab = opened
    [still] = lab.convert(browser, VIEW_CELL)
    assert still.size == (320, 240)
    assert 0.005 < (np.asarray(still.convert("L")) < 128).mean() < 0.3


def test_an_animation_plays(opened: tuple[Browser, JupyterLab]) -> None:
    browser, lab = opened
    [frame] = lab.run_cell(browser, ANIMATION_CELL).find_elements(By.CSS_SELECTOR, ".jp-OutputArea-output iframe")
    before = picture_of(frame)
    ActionChains(browser.driver).move_to_element(frame).click().send_keys(Keys.ARROW_RIGHT).perform()
    time.sleep(0.5)
    assert (picture_of(frame) != before).any()


def test_tab_completes_style_keywords_and_shift_tab_shows_a_signature(opened: tuple[Browser, JupyterLab]) -> None:
    browser, lab = opened
    lab.enter_cell(browser, TYPED_CELL)
    ActionChains(browser.driver).send_keys(Keys.END).send_keys(Keys.TAB).perform()
    shown = "[...document.querySelectorAll('.jp-Completer')].some(each => each.innerText.includes('line_width='))"
    browser.wait_for(shown, CELL_S)
    ActionChains(browser.driver).send_keys(Keys.ENTER).perform()
    cell = f"document.querySelectorAll('.jp-CodeCell')[{TYPED_CELL}]"
    browser.wait_for(f"{cell}.querySelector('.cm-content').innerText.includes('line_width=')", CELL_S)
    ActionChains(browser.driver).key_down(Keys.SHIFT).send_keys(Keys.TAB).key_up(Keys.SHIFT).perform()
    browser.wait_for("document.querySelector('.jp-Tooltip')?.innerText.includes('gx.render(')", CELL_S)
    signature = browser.evaluate("document.querySelector('.jp-Tooltip').innerText")
    assert "line_width=1.5" in signature
    assert "numpy._typing" not in signature
