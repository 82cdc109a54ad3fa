"""Both rasterisers draw the same pictures, and what chooses one of them."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wgpu.backends.wgpu_native._api import libf

import gpu_xform as gx
from gpu_xform import ArgumentError, Camera, DeviceError, Layer, animate, samples, turntable
from gpu_xform.cli import main
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.base import Rasterizer
from gpu_xform.raster.choose import rasterizer_for
from gpu_xform.raster.compute.lines import ComputeLineStage
from gpu_xform.raster.hardware import lines
from gpu_xform.raster.hardware.lines import HardwareLineStage, transmittance_format
from gpu_xform.raster.line_stage import LineStage
from gpu_xform.raster.names import RASTERIZERS
from tests.raster.test_goldens import ALL
from tests.support.types import Pixels

SIZE = (256, 192)
TORUS = samples.torus(24, 12)
SPHERE = samples.icosphere(3)
HEIGHTS = TORUS.positions @ (0.2, 1.0, 0.4)

PICTURES: dict[str, tuple[Any, dict[str, Any]]] = {
    **ALL,
    "many edges": (samples.icosphere(6), {}),
    "faint": (SPHERE, {"alpha": 0.03, "line_width": 6.0}),
    "wide": (SPHERE, {"alpha": 0.4, "line_width": 17.0}),
    "wide, hidden removed": (TORUS, {"hidden": "remove", "line_width": 30.0}),
    "wide, hidden dashed": (TORUS, {"hidden": "dash", "line_width": 20.0, "alpha": 0.6}),
    "wide, hidden faded, by face": (SPHERE, {"hidden": "fade", "line_width": 12.0, "color": "face"}),
    "hidden removed": (SPHERE, {"hidden": "remove"}),
    "depth cue": (TORUS, {"depth_cue": 0.8, "color": "#3060b0"}),
    "depth cue, hidden dashed": (TORUS, {"depth_cue": 0.8, "hidden": "dash", "line_width": 3.0}),
    "silhouette": (samples.icosphere(4), {"edges": "silhouette", "hidden": "remove", "line_width": 3.0}),
    "scalars": (TORUS, {"scalars": HEIGHTS, "alpha": 0.5, "line_width": 4.0}),
    "points": (TORUS, {"point_size": 9.0, "alpha": 0.2, "edges": []}),
    "cloud": (np.random.default_rng(0).normal(size=(5000, 3)), {"point_size": 7.0, "alpha": 0.1}),
    "no background": (samples.house(), {"background": None, "line_width": 3.0}),
    "aliased": (SPHERE, {"antialias": False}),
    "aliased, hidden dashed, by face": (TORUS, {"antialias": False, "hidden": "dash", "color": "face"}),
    "filled": (TORUS, {"fill": "#e0c080", "depth_cue": 0.3}),
    "over one another": (
        [Layer(TORUS, alpha=0.5), Layer(samples.cube(), color="red", antialias=False), Layer(SPHERE, color="face")],
        {},
    ),
}
EXACT = {"cube_in_thin_lines", "snub_dodecahedron_by_face", "scalars_with_dots", "scalars", "aliased"}


def draw(rasterizer: Any, model: Any = SPHERE, size: tuple[int, int] = SIZE, **style: Any) -> Pixels:
    return gx.render_array(model, size=size, rasterizer=rasterizer, **style)


@pytest.mark.parametrize("rasterizer_name", RASTERIZERS[1:2], indirect=True)  # draws with both, or tests none
@pytest.mark.parametrize("name", PICTURES)
def test_both_draw_the_same(name: str) -> None:
    """At most 2/255 anywhere and 0.1/255 on average; what both count in the same integers, to the byte."""
    model, style = PICTURES[name]
    difference = np.abs(draw("render", model, **style).astype(int) - draw("compute", model, **style))
    assert difference.max() <= (0 if name in EXACT else 2)
    assert difference.mean() <= 0.1
    assert (draw("render", model, **style) != draw("render", size=SIZE, model=samples.cube())).any()


@pytest.mark.slow
@pytest.mark.parametrize("rasterizer_name", RASTERIZERS[1:2], indirect=True)  # draws with both, or tests none
@pytest.mark.parametrize("sides", [(24, 12), (48, 24)])
@pytest.mark.parametrize("hidden", ["remove", "dash"])
def test_both_hide_wide_lines_alike_but_for_one_pixel_in_100_000(sides: tuple[int, int], hidden: str) -> None:
    style: dict[str, Any] = {"hidden": hidden, "line_width": 40.0}
    pictures = [draw(name, samples.torus(*sides), (1024, 1024), **style).astype(int) for name in ("render", "compute")]
    difference = np.abs(pictures[0] - pictures[1]).max(axis=2)
    assert (difference > 2).sum() <= difference.size // 100_000
    assert difference.mean() <= 0.1


def test_the_same_picture_has_the_same_bytes(rasterizer_name: str) -> None:
    for style in ({"alpha": 0.3, "line_width": 5.0}, {"color": "face"}):
        assert len({draw(rasterizer_name, TORUS, **style).tobytes() for _ in range(4)}) == 1


def test_half_precision_is_enough_if_the_device_blends_no_more(single_device: GpuDevice, device: GpuDevice) -> None:
    assert transmittance_format(single_device) == "r16float"
    assert transmittance_format(device) == ("r32float" if "float32-blendable" in device.features else "r16float")
    styles: list[dict[str, Any]] = [{}, {"alpha": 0.03, "line_width": 6.0}, {"hidden": "dash", "line_width": 9.0}]
    for style in styles:
        half = draw("render", device=single_device, **style).astype(int)
        assert np.abs(half - draw("compute", device=single_device, **style)).max() <= 2


def lose_device(device: GpuDevice) -> None:
    """Let wgpu lose a device, as if it were unplugged: nothing in Python has been told."""
    libf.wgpuDeviceDestroy(device.context.handle._internal)


def stage_of(device: GpuDevice, name: Any = "auto") -> Any:
    """Return how the rasteriser for a name draws lines."""
    return vars(rasterizer_for(device, name))["_line_stage"]


def test_a_name_chooses_before_the_variable_and_the_variable_before_the_kind_of_adapter(
    device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    stages: dict[str, Any] = {"render": HardwareLineStage, "compute": ComputeLineStage}
    for name, stage in stages.items():
        for variable in ("", "auto", *stages):
            monkeypatch.setenv("GPU_XFORM_RASTERIZER", variable)
            assert stage_of(device, name) is stage
            assert stage_of(device) is stages.get(variable, ComputeLineStage)
    monkeypatch.delenv("GPU_XFORM_RASTERIZER")
    assert device.adapter.kind == "CPU"
    assert stage_of(device) is ComputeLineStage
    for kind in ("DiscreteGPU", "IntegratedGPU", "VirtualGPU", "Unknown"):
        monkeypatch.setattr(device, "adapter", dataclasses.replace(device.adapter, kind=kind))
        assert stage_of(device) is HardwareLineStage


def test_the_variable_chooses_for_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    used: list[type] = []
    whole = LineStage.draw

    def spy(stage: LineStage, *args: Any) -> None:
        used.append(type(stage))
        whole(stage, *args)

    monkeypatch.setattr(LineStage, "draw", spy)
    for name in ("render", "compute"):
        monkeypatch.setenv("GPU_XFORM_RASTERIZER", name)
        gx.render_array(SPHERE, size=SIZE)
    frames = animate(SPHERE, [np.eye(4)], size=SIZE, rasterizer="render")
    list(frames)
    turntable(SPHERE, 1, size=SIZE, rasterizer="compute").frame(0)
    assert used == [HardwareLineStage, ComputeLineStage, HardwareLineStage, ComputeLineStage]


@pytest.mark.parametrize("name", ["Render", "gpu", "", None, 3])
def test_an_unknown_rasterizer_is_an_error_that_names_those_there_are(name: Any) -> None:
    suggestion = re.escape("; did you mean 'render'?") if name == "Render" else ""
    message = rf"^rasterizer must be 'auto', 'render' or 'compute', got {name!r}{suggestion}$"
    for call in (gx.render, gx.render_array):
        with pytest.raises(ArgumentError, match=message):
            call("no such file.obj", rasterizer=name)
    with pytest.raises(ArgumentError, match=message):
        animate(SPHERE, [np.eye(4)], rasterizer=name)


def test_an_unknown_name_in_the_environment_is_an_error_that_names_the_variable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("GPU_XFORM_RASTERIZER", "opengl")
    message = r"^GPU_XFORM_RASTERIZER must be 'auto', 'render' or 'compute', got 'opengl'$"
    with pytest.raises(ArgumentError, match=message):
        gx.render_array(SPHERE, size=SIZE)
    draw("compute")


def test_a_device_that_cannot_draw_lines_says_what_it_lacks_and_what_to_choose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "transmittance_format", lambda _: "rgba8snorm")
    with pytest.raises(
        DeviceError, match=r"cannot draw lines into a texture of rgba8snorm, which rasterizer='compute' does without: "
    ):
        draw("render")
    assert draw("compute").shape == (*SIZE[::-1], 4)


@pytest.mark.parametrize("name", ["one colour", "by face", "aliased"])
def test_a_picture_beyond_the_largest_texture_is_drawn_in_tiles(
    name: str, rasterizer_name: str, device_with_limits: Any
) -> None:
    styles: dict[str, dict[str, Any]] = {
        "one colour": {},
        "by face": {"color": "face"},
        "aliased": {"antialias": False},
    }
    style = styles[name]
    small = device_with_limits(max_texture_side=100)
    assert draw(rasterizer_name, device=small, **style).tobytes() == draw(rasterizer_name, **style).tobytes()


def test_a_device_that_is_closed_in_the_middle_is_an_error(
    rasterizer_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = HardwareLineStage if rasterizer_name == "render" else ComputeLineStage
    whole = stage.draw
    with GpuDevice() as other:

        def close(self: Any, *args: Any) -> None:
            whole(self, *args)
            other.close()

        monkeypatch.setattr(stage, "draw", close)
        with pytest.raises(DeviceError, match="is closed"):
            draw(rasterizer_name, device=other)


@pytest.mark.parametrize("when", ["recording", "reading"])
def test_a_device_that_is_lost_in_the_middle_is_an_error(
    when: str, rasterizer_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = HardwareLineStage if rasterizer_name == "render" else ComputeLineStage
    place, name = {"recording": (stage, "draw"), "reading": (Buffer, "map_read")}[when]
    whole: Any = getattr(place, name)
    with GpuDevice() as other:

        def lose(self: Any, *args: Any) -> Any:
            lose_device(other)
            return whole(self, *args)

        monkeypatch.setattr(place, name, lose)
        with pytest.raises(DeviceError, match="lost"):
            draw(rasterizer_name, device=other)
        monkeypatch.undo()
        with pytest.raises(DeviceError, match="lost"):
            draw(rasterizer_name, device=other)


def test_a_picture_that_fails_leaves_no_file(
    tmp_path: Path, rasterizer_name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = HardwareLineStage if rasterizer_name == "render" else ComputeLineStage

    def fail(*_: Any) -> None:
        raise DeviceError("the device could not draw: lost")

    monkeypatch.setattr(stage, "draw", fail)
    monkeypatch.chdir(tmp_path)
    gx.save_mesh(samples.house(), "house.obj")
    (tmp_path / "old.png").write_bytes(b"old")
    for name in ("new.png", "old.png"):
        assert main(["render", "house.obj", "-o", name, "--rasterizer", rasterizer_name]) != 0
        assert "lost" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"house.obj", "old.png"}
    assert (tmp_path / "old.png").read_bytes() == b"old"


def test_nothing_to_draw_is_an_error_and_nothing_in_view_a_background(rasterizer_name: str) -> None:
    with pytest.raises(ArgumentError, match="models"):
        draw(rasterizer_name, [])
    aside = Camera.window((10.0, 20.0), (10.0, 20.0))
    assert (draw(rasterizer_name, background="#204060", camera=aside) == (0x20, 0x40, 0x60, 255)).all()


def test_an_edge_longer_than_any_picture_is_drawn(rasterizer_name: str) -> None:
    """Some drivers lose lines over 32,768 pixels long."""
    line = gx.Mesh([(-1e6, 0.1, 0.0), (1e6, 0.1, 0.0)], [(0, 1)])
    camera = Camera.window((0.0, 512.0), (-4.0, 4.0))
    picture = draw(rasterizer_name, line, (40_000, 8), camera=camera, line_width=2.0)
    assert (picture[3:5, :, 0].min(axis=0) < 128).all()


@pytest.mark.parametrize("name", RASTERIZERS)
def test_the_command_line_chooses(name: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    gx.save_mesh(samples.house(), "house.obj")
    asked: list[str] = []

    def spy(device: GpuDevice, rasterizer: Any, workload: Any) -> Rasterizer:
        asked.append(rasterizer)
        return rasterizer_for(device, rasterizer, workload)

    monkeypatch.setattr("gpu_xform.rendering.raster.rasterizer_for", spy)
    assert main(["render", "house.obj", "-o", "house.png", "--rasterizer", name, "--size", "90,70"]) == 0
    assert main(["animate", "house.obj", "-o", "house.gif", "--frames", "2", "--rasterizer", name]) == 0
    assert set(asked) == {name}


def test_the_command_line_refuses_other_names_and_pictures_without_pixels(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    gx.save_mesh(samples.house(), "house.obj")
    assert main(["render", "house.obj", "-o", "house.png", "--rasterizer", "opengl"]) == 2
    assert "--rasterizer: expected auto, render, compute, got 'opengl'" in capsys.readouterr().err
    assert main(["render", "house.obj", "-o", "house.svg", "--rasterizer", "render"]) == 2
    assert "house.svg: --rasterizer must come with a .png" in capsys.readouterr().err
    assert main(["render", "house.obj", "-o", "house.svg"]) == 0
