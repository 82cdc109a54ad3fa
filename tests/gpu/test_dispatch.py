"""What is bound to pipelines, and what is sent to the device, once and not again."""

import re
from typing import Any

import numpy as np
import pytest
from wgpu.backends import wgpu_native

import gpu_xform as gx
from gpu_xform import Camera, matrices, samples
from gpu_xform.errors import ShaderError
from gpu_xform.gpu import dispatch
from gpu_xform.gpu.buffers import STORAGE, UNIFORM, Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.shaders import Pipelines
from gpu_xform.gpu.textures import STORAGE as TEXTURE_STORAGE
from gpu_xform.gpu.textures import Texture
from tests.support.wgsl import STAGES, VARIANTS, create_pipeline, source

CAMERA = Camera.window((-2, 2), (-2, 2))
STYLES: list[dict[str, Any]] = [
    {"color": "face"},
    {"hidden": "dash", "line_width": 3.0},
    {"fill": "gold", "color": "face", "line_width": 5.0},
    {"antialias": False, "color": "red"},
    {"color": "face", "size": (200, 130)},
    {"color": "blue"},
]


def draw(device: GpuDevice, **style: Any) -> bytes:
    """Return the pixels of a cube."""
    return gx.render_array(samples.cube(), device=device, **{"camera": CAMERA, "size": (64, 48), **style}).tobytes()


@pytest.fixture
def made(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What has been made and sent since the test began."""
    calls: list[str] = []
    bind_group, upload = type(device.context.handle).create_bind_group, Buffer.upload

    def counted(*arguments: Any, **options: Any) -> Any:
        calls.append("bind group")
        return bind_group(*arguments, **options)

    def sent(buffer: Buffer, array: Any) -> None:
        calls.append("upload")
        upload(buffer, array)

    monkeypatch.setattr(type(device.context.handle), "create_bind_group", counted)
    monkeypatch.setattr(Buffer, "upload", sent)
    return calls


def test_a_frame_like_the_last_binds_nothing_and_sends_its_matrix_alone(device: GpuDevice, made: list[str]) -> None:
    mesh = samples.snub_dodecahedron()
    for k in range(3):
        made.clear()
        turn = matrices.rotate_z(0.1 * k)
        gx.render_array(mesh, device=device, camera=CAMERA, size=(64, 48), color="face", transform=turn)
    assert made == ["upload"]


@pytest.mark.slow
def test_pictures_are_the_same_whatever_was_bound_and_sent_before(device: GpuDevice) -> None:
    with GpuDevice() as fresh:
        expected = []
        for style in STYLES:
            fresh.bind_groups.clear()
            expected.append(draw(fresh, **style))
    for order in np.random.default_rng(1).permuted(np.tile(np.arange(len(STYLES)), (4, 1)), axis=1):
        for k in order.tolist():
            assert draw(device, **STYLES[k]) == expected[k]


def test_no_more_than_a_number_of_groups_is_kept(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = [draw(device, **style) for style in STYLES]
    device.bind_groups.clear()
    monkeypatch.setattr(dispatch, "MAX_BIND_GROUPS", 3)
    assert [draw(device, **style) for style in STYLES] == expected
    assert len(device.bind_groups) == 3


@pytest.mark.parametrize(
    ("names", "got"),
    [
        (["given"], "given"),
        (["given", "shown"], "given, shown"),
        (["given", "seen", "shown"], "given, seen, shown"),
        ([], "none"),
    ],
)
def test_names_that_are_not_the_shaders_are_an_error(names: list[str], got: str, device: GpuDevice) -> None:
    buffers = {name: Buffer(device.context, 80, UNIFORM | STORAGE, label="test") for name in names}
    message = rf"^the bindings of self_test must be given, seen, got {got}$"
    with pytest.raises(ShaderError, match=message):
        device.bind_groups.bind(device.pipelines.compute("self_test"), **buffers)
    for buffer in buffers.values():
        buffer.release()


@pytest.mark.parametrize(
    ("stage", "number_type"),
    [pytest.param(*each, marks=[pytest.mark.float64] if each[1] == "f64" else []) for each in VARIANTS],
)
def test_a_stage_uses_every_binding_that_it_declares(stage: str, number_type: str | None, device: GpuDevice) -> None:
    """The layout of a pipeline holds what its shader uses: it refuses a group with more."""
    constants = dict.fromkeys((name for names in STAGES[stage].overrides.values() for name in names), 1.0)
    pipeline = create_pipeline(device, stage, number_type, constants)
    code = source(stage, number_type).code

    def create(name: str) -> Buffer | Texture:
        if f" {name}: texture_2d<f32>" in code:
            return Texture(device.context, (4, 4), "rgba8unorm", label=name)
        if storage := re.search(rf" {name}: texture_storage_2d<(\w+),", code):
            return Texture(device.context, (4, 4), storage[1], TEXTURE_STORAGE, label=name)
        usage = UNIFORM if f"var<uniform> {name}:" in code else STORAGE
        return Buffer(device.context, 65536, usage, label=name)

    parts = {name: create(name) for name in pipeline.bindings}
    device.bind_groups.bind(pipeline, **dict(reversed(parts.items())))  # does not raise
    for part in parts.values():
        part.release()


def test_what_comes_and_goes_is_not_kept(device: GpuDevice) -> None:
    device.bind_groups.clear()
    draw(device)
    with gx.PointBuffer(np.eye(3, dtype=np.float32), device=device) as points:
        gx.render_array(points, edges=[(0, 1)], device=device, camera=CAMERA, size=(64, 48))
        own = points.device_points().buffer.id
    kept = {number for _, *parts in device.bind_groups._groups for _, number, *_ in parts}
    assert kept
    assert own not in kept


def test_dispatches_in_a_row_share_a_pass_unless_each_is_timed(
    device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[str] = []

    def spy(encoder: wgpu_native.GPUCommandEncoder, **options: Any) -> Any:
        begun.append(encoder.label)
        return begin(encoder, **options)

    begin = wgpu_native.GPUCommandEncoder.begin_compute_pass
    monkeypatch.setattr(wgpu_native.GPUCommandEncoder, "begin_compute_pass", spy)
    together = draw(device, hidden="dash")
    n_together = len(begun)
    with device.time_dispatches() as timer:
        assert draw(device, hidden="dash") == together
        labels = [time.label for time in timer.times]
    n_dispatches = len([label for label in labels if not label.startswith("composite_")])
    assert len(begun) - n_together == n_dispatches
    assert 0 < n_together < n_dispatches


def test_passes_that_must_round_alike_share_one_pipeline(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two may round otherwise: faces would not be as near as they were found, edges have more pieces than counted."""
    asked: list[tuple[str, str]] = []
    compute = Pipelines.compute

    def spy(pipelines: Pipelines, stage: str, number_type: str | None = None, **constants: float) -> Any:
        asked.append((stage, repr(sorted(constants.items()))))
        return compute(pipelines, stage, number_type, **constants)

    monkeypatch.setattr(Pipelines, "compute", spy)
    gx.render_svg(samples.snub_dodecahedron(), device=device, camera=CAMERA, hidden="dash", fill="face")
    for stage in ("depth_small_triangles", "depth_large_triangles", "split_edges_by_visibility"):
        assert len({constants for name, constants in asked if name == stage}) == 1
