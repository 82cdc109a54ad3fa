"""Pages in Chromium: WebGPU on SwiftShader draws what `render_array` does, and a 2D canvas much the same."""

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.gpu.wgsl import installed_sources
from gpu_xform.viewer.controls import Controls, InitialView
from gpu_xform.viewer.orbit import BoundingSphere
from gpu_xform.web import program
from gpu_xform.web.short_program import make_program
from tests.support.browser import Browser
from tests.support.wgsl import VARIANTS

SIZE = (128, 96)
TOLERANCE = 2  # of 255

OPEN = """
const done = arguments[0];
window.gpuXform.then(page => done(page.renderer.name)).catch(error => done(String(error.stack)));
"""

READ = """
const [size, scene, options, done] = arguments;
const text = bytes => btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(""));
window.gpuXform
  .then(async page => scene ? page.readPixelsOf(await page.decode(scene), size) : page.readPixels(size, options))
  .then(pixels => done(text(pixels)), error => done(String(error.stack)));
"""


def open_page(browser: Browser, path: Path, query: str = "") -> str:
    """Open a page; return what draws it."""
    browser.open(path, SIZE)
    if query:
        browser.driver.get(path.resolve().as_uri() + query)
    browser.driver.set_script_timeout(60)
    return str(browser.driver.execute_async_script(OPEN))


def read_pixels(browser: Browser, scene: str | None = None, **options: Any) -> npt.NDArray[np.uint8]:
    """Return what the page draws of its own scene, or of another one, (height, width, 4)."""
    text: str = browser.driver.execute_async_script(READ, list(SIZE), scene, options)
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(SIZE[1], SIZE[0], 4)


def scene_of(path: Path) -> str:
    return path.read_text("utf-8").split('id="scene">')[1].split("<")[0]


def press(browser: Browser, *keys: str) -> None:
    for key in keys:
        browser.driver.execute_script("livePage.press(arguments[0])", key)


@pytest.fixture(scope="module")
def webgpu() -> Iterator[Browser]:
    with Browser(webgpu=True) as browser:
        yield browser


@pytest.fixture(scope="module")
def page(webgpu: Browser, tmp_path_factory: pytest.TempPathFactory) -> Browser:
    """A browser that shows a page of a torus."""
    path = tmp_path_factory.mktemp("pages") / "torus.html"
    gx.save_page(RING, path, size=SIZE)
    assert open_page(webgpu, path) == "WebGPU"
    return webgpu


def largest_difference(pixels: npt.NDArray[np.uint8], picture: npt.NDArray[np.uint8]) -> int:
    return int(np.abs(pixels.astype(int) - picture).max())


RING = gx.samples.torus(24, 12).transformed(gx.rotate_x(0.3) @ gx.rotate((1, 2, 3), 0.2))
BRICK = gx.Layer(gx.samples.cube(), transform=gx.translate(0.7, 0.2, 0.1) @ gx.scale(0.4), color="navy")
PLACES = np.stack([gx.translate(2.5 * k, 0.3 * k, 0) for k in range(3)])
SCENES: dict[str, tuple[Any, dict[str, Any]]] = {
    "lines": (RING, {"line_width": 1.2}),
    "hidden lines": (RING, {"hidden": "remove", "color": "#204080"}),
    "dashes": (gx.samples.house(), {"hidden": "dash", "line_width": 2.0}),
    "fading": (RING, {"hidden": "fade", "depth_cue": 0.6, "camera": {"orthographic": True}}),
    "fills": (RING, {"fill": "gold", "alpha": 0.8, "background": "#203040"}),
    "shaded faces": (gx.samples.house(), {"fill": "face", "shading": "flat", "edges": "feature"}),
    "smooth shading": (RING, {"fill": "#80c0ff", "shading": "smooth", "edges": "silhouette", "transform": PLACES}),
    "colours": (RING, {"scalars": RING.positions[:, 1], "line_width": 3.0, "hidden": "remove"}),
    "silhouettes": (RING, {"edges": ["feature", "silhouette"], "hidden": "dash", "hidden_style": {"color": "red"}}),
    "layers": ([gx.Layer(RING, fill="tan"), BRICK], {"background": None}),
    "instances": (gx.samples.cube(), {"transform": PLACES, "antialias": False, "fill": "white", "point_size": 5.0}),
    "points": (RING.positions, {"color": "purple"}),
    "repeated indices": (gx.samples.icosphere(2), {"hidden": "remove", "fill": "face"}),
}


@pytest.mark.browser
@pytest.mark.parametrize("name", SCENES)
def test_a_page_draws_what_python_draws(name: str, page: Browser, tmp_path: Path) -> None:
    models, options = SCENES[name]
    gx.save_page(models, tmp_path / "page.html", size=SIZE, **options)
    pixels = read_pixels(page, scene_of(tmp_path / "page.html"))
    picture = gx.render_array(models, size=SIZE, rasterizer="compute", **options)
    straight = np.round(pixels[..., :3] * (255.0 / np.maximum(pixels[..., 3:], 1)))
    assert len(np.unique(picture)) > 1
    assert largest_difference(np.concatenate([straight, pixels[..., 3:]], axis=-1), picture) <= TOLERANCE
    assert page.console_messages() == []


@pytest.mark.browser
def test_keys_change_the_style_and_the_view_as_in_the_window(page: Browser) -> None:
    first = read_pixels(page)
    press(page, "f", "d", "e", "b")
    overridden: dict[str, Any] = {"fill": "lightgray", "hidden": "dash", "edges": "feature", "background": "#1e1e1e"}
    picture = gx.render_array(RING, size=SIZE, rasterizer="compute", **overridden)
    assert largest_difference(read_pixels(page), picture) <= TOLERANCE
    press(page, "1", "ArrowLeft", "p")
    assert largest_difference(read_pixels(page), picture) > 50
    press(page, "Backspace", "r")
    assert np.array_equal(read_pixels(page), first)
    press(page, "e", "e")  # past the boundary, which a ring has not
    outline = gx.render_array(RING, size=SIZE, rasterizer="compute", edges="silhouette")
    assert largest_difference(read_pixels(page), outline) <= TOLERANCE
    press(page, "e")
    assert np.array_equal(read_pixels(page), first)


POINTER = """
const {controls} = livePage, [w, h] = controls.size;
const event = (x, y, more) => ({pointerId: 1, offsetX: x, offsetY: y, button: 0, buttons: 1, ...more});
const drag = (from, to, more) => {
    controls.fingers.set(1, {at: from, pans: Boolean(more.shiftKey)});
    controls.move(event(...to, more));
    controls.release(event(...to, more));
};
drag([10, 20], [40, 25], {});
drag([30, 40], [50, 35], {shiftKey: true});
controls.wheel({...event(30, 70), deltaY: 150, deltaMode: 0, preventDefault() {}});
const matrix = controls.orbit.clipFromWorld(w / h);
livePage.press("r");
return matrix;
"""


@pytest.mark.browser
def test_the_pointer_moves_the_view_as_in_the_window(page: Browser) -> None:
    camera, points = gx.Camera.fit(RING), RING.positions
    window = Controls(InitialView(camera, BoundingSphere.around(points), lambda: points, gx.Layer(RING), "white", None))

    def send(kind: str, x: float, y: float, **more: Any) -> None:
        event = {"event_type": kind, "x": x, "y": y, "button": 1, "buttons": (1,), "modifiers": (), **more}
        window.handle(event, SIZE)

    for start, end, modifiers in (((10, 20), (40, 25), ()), ((30, 40), (50, 35), ("Shift",))):
        send("pointer_down", *start, modifiers=modifiers)
        send("pointer_move", *end, modifiers=modifiers)
        send("pointer_up", *end, modifiers=modifiers)
    send("wheel", 30, 70, dy=150.0)
    assert window.view.orbit is not None
    expected = window.view.orbit.camera.clip_from_world(SIZE[0] / SIZE[1])
    found = np.array(page.driver.execute_script(make_program().names.rename_script(POINTER)))
    assert np.allclose(found[[0, 1, 3]], expected[[0, 1, 3]], rtol=1e-5, atol=1e-5)


# The classes whose objects the scripts use.
CLASSES = (
    *("Array", "ArrayBuffer", "Blob", "CanvasRenderingContext2D", "DataView", "Float32Array", "Function", "GPU"),
    *("GPUAdapter", "GPUBindGroup", "GPUBuffer", "GPUCanvasContext", "GPUCommandEncoder", "GPUComputePassEncoder"),
    *("GPUComputePipeline", "GPUDevice", "GPUQueue", "GPURenderPassEncoder", "GPURenderPipeline", "GPUShaderModule"),
    *("GPUSupportedLimits", "GPUTexture", "GPUTextureView", "HTMLAnchorElement", "HTMLButtonElement"),
    *("HTMLCanvasElement", "HTMLDivElement", "HTMLInputElement", "HTMLOutputElement", "HTMLSelectElement"),
    *("ImageData", "KeyboardEvent", "Location", "Map", "Navigator", "OffscreenCanvas", "Path2D", "Performance"),
    *("PointerEvent", "Promise", "RegExp", "ResizeObserver", "Set", "String", "URL", "URLSearchParams", "Uint32Array"),
    *("WeakMap", "WheelEvent", "HTMLDocument", "OffscreenCanvasRenderingContext2D"),
)
LIST_PROPERTIES = """
const names = new Set();
for (const name of arguments[0]) {
  const found = globalThis[name];
  for (let at = found.prototype; at && at !== Object.prototype; at = Object.getPrototypeOf(at))
    Object.getOwnPropertyNames(at).forEach(own => names.add(own));
}
for (const object of [Math, JSON, URL, Object, Array, Promise, GPUBufferUsage, GPUTextureUsage, GPUMapMode])
  Object.getOwnPropertyNames(object).forEach(own => names.add(own));
return [...names];
"""


@pytest.mark.browser
def test_imports_are_resolved_alike_in_both_languages(page: Browser) -> None:
    sources = installed_sources()
    files = {path.stem: path.read_text("utf-8") for path in Path(str(sources.folder)).rglob("*.wgsl")}
    script = program.read_script("wgsl").replace("export ", "")
    stages = [(stage, number_type) for stage, number_type in VARIANTS if number_type != "f64"]
    code = "return arguments[1].map(file => resolveImports(arguments[0], file)).map(text => [text, findBindings(text)])"
    names = [Path(sources.stages[stage].file).stem for stage, _ in stages]
    resolved = page.driver.execute_script(script + code, files, names)
    for (stage, number_type), (text, bindings) in zip(stages, resolved, strict=True):
        expected = sources.source(stage, number_type)
        assert text.rstrip("\n") == expected.code.rstrip("\n"), stage
        assert bindings == dict(expected.bindings)


@pytest.mark.browser
def test_no_short_name_stands_for_one_of_the_browsers(page: Browser) -> None:
    theirs = set(page.driver.execute_script(LIST_PROPERTIES, CLASSES))
    assert {"fillRect", "hypot", "dispatchWorkgroups", "COPY_DST", "pointerId"} <= theirs
    assert sorted(theirs & make_program().names.shared.keys()) == []


@pytest.mark.browser
def test_without_webgpu_a_canvas_shows_much_the_same(browser: Browser, tmp_path: Path) -> None:
    gx.save_page(gx.samples.house(), tmp_path / "house.html", size=SIZE, fill="gold", line_width=2.0)
    assert open_page(browser, tmp_path / "house.html") == "Canvas 2D"
    browser.wait_for("document.documentElement.classList.contains('live')")
    picture = gx.render_array(gx.samples.house(), size=SIZE, fill="gold", line_width=2.0).astype(int)
    difference = np.abs(read_pixels(browser).astype(int) - picture)
    assert (difference.max(axis=-1) > 64).mean() < 0.02
    assert all("No available adapters" in message for message in browser.console_messages())


@pytest.mark.browser
def test_without_scripts_the_poster_is_shown(browser: Browser, tmp_path: Path) -> None:
    gx.save_page(gx.samples.house(), tmp_path / "house.html", size=SIZE, fill="gold")
    browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.open(tmp_path / "house.html", SIZE)
        shown = browser.screenshot()
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
    picture = gx.render_array(gx.samples.house(), size=SIZE, fill="gold").astype(int)
    assert np.abs(shown.astype(int) - picture).mean() < 8


@pytest.mark.browser
def test_an_animation_plays_and_a_lost_driver_leaves_a_canvas(webgpu: Browser, tmp_path: Path) -> None:
    turns = [gx.rotate_y(0.5 * k) for k in range(3)]
    house = gx.samples.house()
    camera = gx.Camera.fit(house)
    gx.save_page(house, tmp_path / "house.html", turns, fps=50, size=SIZE, camera=camera, hidden="remove")
    assert open_page(webgpu, tmp_path / "house.html") == "WebGPU"
    picture = gx.render_array(
        house, transform=turns[2], size=SIZE, camera=camera, hidden="remove", rasterizer="compute"
    )
    assert largest_difference(read_pixels(webgpu, frame=2), picture) <= TOLERANCE
    names = make_program().names
    webgpu.driver.execute_script("livePage.press(' ')")
    webgpu.wait_for(names.rename_script("livePage.player.frame===2"))
    lose = "livePage.player.stop(); livePage.player.show(2); livePage.renderer.device.destroy()"
    webgpu.driver.execute_script(names.rename_script(lose))
    webgpu.wait_for("document.documentElement.dataset.renderer === 'Canvas 2D'")
    difference = np.abs(read_pixels(webgpu).astype(int) - picture)
    assert (difference.max(axis=-1) > 96).mean() < 0.02
