"""The player in a page, used as a hand uses it, in a real browser."""

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import gpu_xform as gx
from tests.support.browser import Browser

N_FRAMES = 12
SIZE = (200, 150)
WINDOW = (400, 300)
SHOWN = "Number(document.querySelector('canvas').dataset.frame)"
PLAYING = "document.getElementById('play').getAttribute('aria-pressed') === 'true'"


@pytest.fixture(scope="module")
def animation() -> gx.Animation:
    return gx.turntable(gx.samples.house(), N_FRAMES, size=SIZE, fps=10, color="face", line_width=3)


@pytest.fixture(scope="module")
def page(animation: gx.Animation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("player") / "house.html"
    animation.save(path)
    return path


@pytest.fixture
def player(browser: Browser, page: Path) -> Browser:
    browser.open(page, WINDOW)
    browser.wait_for(f"{SHOWN} === 0")
    return browser


def canvas(browser: Browser) -> npt.NDArray[np.uint8]:
    """Return what is seen of the picture."""
    place = browser.evaluate(
        "(r => [r.left, r.top, r.width, r.height])(document.querySelector('canvas').getBoundingClientRect())"
    )
    left, top, width, height = (round(side) for side in place)
    return browser.screenshot()[top : top + height, left : left + width]


def draw(animation: gx.Animation, k: int) -> npt.NDArray[np.uint8]:
    return np.asarray(animation.frame(k), np.uint8)


def press(browser: Browser, *keys: str, on: str = "body") -> None:
    browser.driver.find_element(By.CSS_SELECTOR, on).send_keys(*keys)


def test_it_begins_with_the_first_frame_at_rest(player: Browser, animation: gx.Animation) -> None:
    assert np.array_equal(canvas(player), draw(animation, 0))
    assert not player.evaluate(PLAYING)
    assert player.evaluate("document.getElementById('number').textContent").split() == ["1", "/", "12"]
    assert player.console_messages() == []


def test_a_click_on_play_changes_the_picture_until_the_next(player: Browser, animation: gx.Animation) -> None:
    before = canvas(player)
    player.click("#play")
    player.wait_for(f"{SHOWN} >= 2")
    assert player.evaluate(PLAYING)
    player.click("#play")
    assert not player.evaluate(PLAYING)
    shown = player.evaluate(SHOWN)
    after = canvas(player)
    assert not np.array_equal(after, before)
    assert np.array_equal(after, draw(animation, shown))
    player.driver.execute_async_script("setTimeout(arguments[0], 300)")
    assert player.evaluate(SHOWN) == shown
    assert player.console_messages() == []


def test_every_frame_is_there_to_the_last_bit(player: Browser, animation: gx.Animation) -> None:
    for k in range(1, N_FRAMES):
        player.click("#forward")
        player.wait_for(f"{SHOWN} === {k}")
        assert np.array_equal(canvas(player), draw(animation, k))


def test_steps_go_round_and_stop_it(player: Browser) -> None:
    player.click("#play")
    player.click("#back")
    assert not player.evaluate(PLAYING)
    for _ in range(N_FRAMES):
        shown = player.evaluate(SHOWN)
        player.click("#back")
        player.wait_for(f"{SHOWN} === {(shown - 1) % N_FRAMES}")
    shown = player.evaluate(SHOWN)
    player.click("#forward")
    player.wait_for(f"{SHOWN} === {(shown + 1) % N_FRAMES}")


def test_the_slider_shows_the_frame_that_it_is_moved_to(player: Browser, animation: gx.Animation) -> None:
    press(player, Keys.END, on="#slider")
    player.wait_for(f"{SHOWN} === {N_FRAMES - 1}")
    assert np.array_equal(canvas(player), draw(animation, -1))
    press(player, Keys.ARROW_LEFT, Keys.ARROW_LEFT, on="#slider")
    player.wait_for(f"{SHOWN} === {N_FRAMES - 3}")
    assert player.evaluate("document.getElementById('slider').getAttribute('aria-valuetext')") == "frame 10 of 12"


def test_the_keyboard_does_it_all(player: Browser) -> None:
    press(player, Keys.ARROW_RIGHT)
    player.wait_for(f"{SHOWN} === 1")
    press(player, Keys.END)
    player.wait_for(f"{SHOWN} === {N_FRAMES - 1}")
    press(player, Keys.ARROW_LEFT)
    player.wait_for(f"{SHOWN} === {N_FRAMES - 2}")
    press(player, Keys.HOME)
    player.wait_for(f"{SHOWN} === 0")
    press(player, " ")
    player.wait_for(f"{SHOWN} >= 1")
    press(player, " ")
    assert not player.evaluate(PLAYING)
    # On a button the space bar presses that button, and no second time what it means elsewhere.
    press(player, " ", on="#play")
    assert player.evaluate(PLAYING)
    press(player, " ", on="#play")
    assert not player.evaluate(PLAYING)
    looping = "document.getElementById('loop').getAttribute('aria-pressed')"
    assert player.evaluate(looping) == "true"
    press(player, "l")
    assert player.evaluate(looping) == "false"


def test_it_loops_unless_it_is_told_not_to(player: Browser) -> None:
    player.driver.execute_script("document.getElementById('speed').value = 4")
    press(player, Keys.END)
    player.wait_for(f"{SHOWN} === {N_FRAMES - 1}")
    player.click("#play")
    player.wait_for(f"{SHOWN} === 1")
    player.click("#loop")
    player.wait_for(f"!({PLAYING})")
    player.wait_for(f"{SHOWN} === {N_FRAMES - 1}")
    player.click("#play")
    player.wait_for(f"{SHOWN} === 2")
    assert player.evaluate(PLAYING)


@pytest.mark.parametrize(("speed", "seconds"), [("1", 0.6), ("4", 0.15), ("0.5", 1.2)])
def test_it_keeps_time(player: Browser, speed: str, seconds: float) -> None:
    """Six frames of ten a second take six tenths, within two frames of the screen and one of the animation."""
    player.driver.execute_script(f"document.getElementById('speed').value = '{speed}'")
    elapsed = player.driver.execute_async_script(f"""
        const done = arguments[0], began = performance.now();
        document.getElementById('play').click();
        (function look() {{
            if ({SHOWN} >= 6) done(performance.now() - began); else requestAnimationFrame(look);
        }})();""")
    slack = 0.1 / float(speed)
    assert seconds - 0.05 <= elapsed / 1000 <= seconds + slack + 0.25


def test_everything_has_a_name_and_can_be_reached(player: Browser) -> None:
    controls = player.driver.find_elements(By.CSS_SELECTOR, "button, input, select")
    assert len(controls) == 6
    assert all(control.accessible_name and control.is_displayed() for control in controls)
    reached: list[str] = []
    for _ in controls:
        press(player, Keys.TAB, on=":focus" if reached else "body")
        reached.append(player.evaluate("document.activeElement.id"))
    assert reached == ["back", "play", "forward", "slider", "speed", "loop"]


def test_transparent_pictures_let_the_page_through(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "thin.html"
    thin = gx.turntable(gx.samples.house(), 3, path, size=SIZE, background=None, line_width=4)
    browser.open(path, WINDOW)
    browser.wait_for(f"{SHOWN} === 0")
    browser.driver.execute_script("document.body.style.background = 'rgb(0 128 0)'")
    browser.click("#forward")
    browser.wait_for(f"{SHOWN} === 1")
    pixels = canvas(browser)
    alpha = draw(thin, 1)[..., 3]
    assert (pixels[alpha == 0] == (0, 128, 0, 255)).all()
    assert (pixels[alpha == 255] == (0, 0, 0, 255)).all()
    assert (alpha == 255).any()


@pytest.mark.parametrize("window", [(800, 600), (320, 240), (180, 400), (400, 120)])
def test_it_fits_its_window_without_stretching_or_scrolling(
    browser: Browser, page: Path, window: tuple[int, int]
) -> None:
    browser.open(page, window)
    browser.wait_for(f"{SHOWN} === 0")
    width, height = browser.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    assert (width, height) <= window
    assert browser.evaluate("getComputedStyle(document.querySelector('canvas')).objectFit") == "contain"
    for control in browser.driver.find_elements(By.CSS_SELECTOR, "button, input, select"):
        if control.is_displayed() or window[0] > 300:
            assert 0 <= control.rect["x"] < control.rect["x"] + control.rect["width"] <= window[0]
            assert 0 <= control.rect["y"] < control.rect["y"] + control.rect["height"] <= window[1]


def test_small_pictures_of_many_frames_leave_the_slider_room(browser: Browser, page: Path, tmp_path: Path) -> None:
    path = tmp_path / "many.html"
    path.write_text(page.read_text("utf-8").replace(f'"nFrames": {N_FRAMES}', '"nFrames": 10000'), "utf-8")
    browser.open(path, (800, 600))
    browser.wait_for(f"{SHOWN} === 0")
    assert browser.evaluate("number.textContent").endswith("1 / 10000")
    assert browser.evaluate("slider.offsetWidth") > 120


def test_a_notebook_shows_several_apart(browser: Browser, animation: gx.Animation, tmp_path: Path) -> None:
    """Each is in a frame of its own: neither names nor keys meet."""
    other = gx.turntable(gx.samples.cube(), 3, size=(300, 100), background="#ffe0c0")
    path = tmp_path / "notebook.html"
    cells = animation._repr_html_() + "<p>between</p>" + other._repr_html_()
    path.write_text(f"<!doctype html><meta charset='utf-8'><body style='margin: 0; width: 500px'>{cells}", "utf-8")
    browser.open(path, (600, 700))
    frames = browser.driver.find_elements(By.TAG_NAME, "iframe")
    assert len(frames) == 2
    browser.driver.switch_to.frame(frames[1])
    browser.wait_for(f"{SHOWN} === 0")
    browser.click("#forward")
    browser.wait_for(f"{SHOWN} === 1")
    browser.driver.switch_to.default_content()
    browser.driver.switch_to.frame(frames[0])
    browser.wait_for(f"{SHOWN} === 0")
    browser.driver.switch_to.default_content()
    pixels = browser.screenshot()
    left, top = round(frames[0].rect["x"]), round(frames[0].rect["y"])
    assert frames[0].rect["width"] == 480
    assert np.array_equal(pixels[top : top + 150, left + 140 : left + 340], draw(animation, 0))
    left, top = round(frames[1].rect["x"]), round(frames[1].rect["y"])
    assert np.array_equal(pixels[top : top + 100, left + 90 : left + 390], draw(other, 1))
    assert browser.console_messages() == []


def test_a_page_is_complete_in_itself(page: Path) -> None:
    text = re.sub("[A-Za-z0-9+/=]{100,}", "", page.read_text("utf-8"))
    assert re.findall(r"\bsrc\b.*", text) == ["src = `data:image/${format};base64,${frames[k]}`;"]
    assert '"format": "webp"' in text
    assert not re.search(r"href|https?:|@import|url\(", text)


def test_a_page_has_the_name_of_its_model_as_title(tmp_path: Path) -> None:
    cube = gx.Layer(gx.samples.cube(), name="A <cube>")
    for models, title in (
        (cube, "A &lt;cube&gt;"),
        ([cube, cube], "A &lt;cube&gt; and 1 more"),
        (cube.model, "Animation"),
    ):
        gx.turntable(models, 2, tmp_path / "page.html", size=(16, 12))
        assert f"<title>{title}</title>" in (tmp_path / "page.html").read_text("utf-8")


def test_a_notebook_shows_a_long_animation_in_less_than_a_megabyte(browser: Browser, tmp_path: Path) -> None:
    ball = gx.samples.snub_dodecahedron()
    turn = gx.turntable(ball, 60, size=(240, 240), color="face", camera=gx.Camera.window((-2.4, 2.4), (-2.4, 2.4)))
    cell = turn._repr_html_()
    turn.save(tmp_path / "lossless.html")
    assert (tmp_path / "lossless.html").stat().st_size > 1_500_000
    assert len(cell.encode()) <= 1_000_000
    path = tmp_path / "notebook.html"
    path.write_text(f"<!doctype html><meta charset='utf-8'><body style='margin: 0; width: 480px'>{cell}", "utf-8")
    browser.open(path, (480, 340))
    browser.wait_for("document.querySelector('iframe').contentDocument.querySelector('canvas')?.dataset.frame === '0'")
    shot = browser.screenshot()[:240, 120:360, :3].astype(int)
    exact = draw(turn, 0)[..., :3].astype(int)
    assert np.abs(shot - exact).mean() < 4
    colors = shot[np.ptp(shot, axis=2) > 120]  # saturated, as thin coloured lines are where colours are not blurred
    assert len(colors) > 0.5 * np.count_nonzero(np.ptp(exact, axis=2) > 120)
