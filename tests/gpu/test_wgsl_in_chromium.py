"""Every stage compiles in Chromium too, whose compiler accepts other programs than wgpu's."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from tests.support.browser import Browser
from tests.support.wgsl import STAGES, VARIANTS, source

OPEN = """
const done = arguments[0];
navigator.gpu.requestAdapter().then(adapter => adapter.requestDevice()).then(device => {
    window.device = device;
    done("");
}).catch(error => done(String(error)));
"""

COMPILE = """
const [code, entryPoints, constants, writeMask, done] = arguments;
(async () => {
    const module = device.createShaderModule({code});
    const messages = (await module.getCompilationInfo()).messages;
    if (messages.length) return messages.map(each => `${each.lineNum}: ${each.message}`);
    const stage = kind => ({module, entryPoint: entryPoints[kind], constants});
    if (entryPoints.compute) {
        await device.createComputePipelineAsync({layout: "auto", compute: stage("compute")});
    } else {
        const fragment = {...stage("fragment"), targets: [{format: "rgba8unorm", writeMask}]};
        await device.createRenderPipelineAsync({layout: "auto", vertex: stage("vertex"), fragment});
    }
    return [];
})().then(done, error => done([String(error)]));
"""


@pytest.fixture(scope="module")
def webgpu(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A page with a WebGPU device."""
    page = tmp_path_factory.mktemp("webgpu") / "empty.html"
    page.write_text("<!doctype html><title>WebGPU</title>", "utf-8")
    with Browser(webgpu=True) as browser:
        browser.open(page, (20, 20))
        assert browser.driver.execute_async_script(OPEN) == ""
        yield browser


def compile_in(browser: Browser, code: str, entry_points: Mapping[str, str], constants: dict[str, float]) -> list[str]:
    """Return what the browser's compiler says of WGSL."""
    writes_colors = bool(re.search(r"fn fragment_main\([^)]*\) *->", code))
    write_mask = 0xF if writes_colors else 0
    said: Any = browser.driver.execute_async_script(COMPILE, code, dict(entry_points), constants, write_mask)
    return [str(line) for line in said]


@pytest.mark.browser
@pytest.mark.parametrize("stage", [stage for stage, number_type in VARIANTS if number_type != "f64"])
def test_every_stage_compiles_in_chromium(stage: str, webgpu: Browser) -> None:
    """Those in double precision do not: WebGPU has none, and wgpu's is an extension."""
    row = STAGES[stage]
    constants = {name: 1.0 for names in row.overrides.values() for name in names}
    assert compile_in(webgpu, source(stage).code, row.entry_points, constants) == []


@pytest.mark.browser
def test_a_shader_that_does_not_compile_in_chromium_is_noticed(webgpu: Browser) -> None:
    [message] = compile_in(webgpu, "\nfn main() -> u32 { return 1.5; }", {"compute": "main"}, {})
    assert message.startswith("2: ")
