"""The browser of the tests: it shows what a page paints, pixel by pixel, and clicks as a mouse does."""

from pathlib import Path

import pytest
from selenium.common.exceptions import TimeoutException

from tests.support.browser import Browser

PAGE = """<!doctype html><title>squares</title>
<style>body { margin: 0 } div { position: absolute; left: 3px; top: 5px; width: 7px; height: 11px; background: #c80 }
button { position: absolute; left: 100px; top: 20px }</style>
<div></div><button onclick="setTimeout(turn, 50)">turn</button>
<script>function turn() { document.querySelector("div").style.background = "rgb(0 0 255 / 20%)"; turned = true }
let turned = false</script>"""


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "squares #1.html"
    path.write_text(PAGE, "utf-8")
    return path


@pytest.mark.parametrize("size", [(301, 77), (1203, 1011)])
def test_a_picture_is_what_the_page_paints_and_no_more(browser: Browser, page: Path, size: tuple[int, int]) -> None:
    browser.open(page, size)
    picture = browser.screenshot()
    assert picture.shape == (size[1], size[0], 4)
    square = picture[5:16, 3:10]
    assert (square == (0xCC, 0x88, 0, 255)).all()
    assert picture[:20, :90, 3].sum() == square[..., 3].sum()


def test_a_click_does_what_a_hand_would_and_the_page_is_waited_for(browser: Browser, page: Path) -> None:
    browser.open(page, (301, 77))
    assert browser.evaluate("turned") is False
    browser.click("button")
    browser.wait_for("turned")
    assert browser.screenshot()[10, 5].tolist() == [0, 0, 255, 51]
    assert browser.console_messages() == []


def test_what_is_true_for_one_frame_is_not_missed(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "flash.html"
    path.write_text(
        """<!doctype html><script>let flash = false
        const once = () => requestAnimationFrame(() => { flash = true; requestAnimationFrame(() => { flash = false }) })
        </script><button onclick="setTimeout(once, 200)">flash</button>""",
        "utf-8",
    )
    browser.open(path, (50, 50))
    for _ in range(5):
        browser.click("button")
        browser.wait_for("flash", seconds=5.0)


def test_what_never_comes_is_an_error(browser: Browser, page: Path) -> None:
    browser.open(page, (301, 77))
    with pytest.raises(TimeoutException, match="still false: turned"):
        browser.wait_for("turned", seconds=0.1)


def test_a_page_that_fails_or_needs_the_network_is_heard(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(
        "<!doctype html><script src='https://example.org/a.js'></script><script>missing()</script>", "utf-8"
    )
    browser.open(path, (20, 20))
    network, script = browser.console_messages()
    assert "ERR_NAME_NOT_RESOLVED" in network
    assert "missing is not defined" in script
    path.write_text("<!doctype html><p>fine", "utf-8")
    browser.open(path, (20, 20))
    assert browser.console_messages() == []


def test_a_machine_without_a_browser_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(RuntimeError, match="make browser"):
        Browser()
