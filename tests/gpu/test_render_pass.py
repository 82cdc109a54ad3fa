"""Render passes: triangles into textures, by stages with a vertex and a fragment entry point."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest

from gpu_xform.errors import DeviceError, ShaderError
from gpu_xform.gpu.buffers import READBACK, UNIFORM, Buffer, Usage
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.dispatch import begin_render_pass
from gpu_xform.gpu.shaders import ColorWrite
from gpu_xform.gpu.textures import Texture, align_row
from tests.support.wgsl import FOLDER

STAGE = """
@group(0) @binding(0) var<uniform> color: vec4<f32>;
override factor: f32;

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    // Vertices 0 to 3 are the corners of the left half of the viewport, 4 to 7 those of the right half.
    let corner = vertex & 3u;
    let x = -1.0 + f32(vertex >> 2u) + f32(corner & 1u);
    return vec4(x, 1.0 - 2.0 * f32(corner >> 1u), 0.0, 1.0);
}

@fragment
fn fragment_main() -> @location(0) vec4<f32> {
    return factor * color;
}
"""
TABLE = """
[paint]
file = "paint.wgsl"
entry_points = { vertex = "vertex_main", fragment = "fragment_main" }
overrides.f32 = ["factor"]

[self_test]
file = "self_test.wgsl"
"""
EXTENT = (6, 4)
QUAD = np.array([0, 1, 2, 2, 1, 3], np.uint16)
Pixels = npt.NDArray[np.uint8]


@pytest.fixture(scope="module")
def painter(tmp_path_factory: pytest.TempPathFactory) -> Iterator[GpuDevice]:
    """A device with a stage that paints quads in one colour."""
    folder = tmp_path_factory.mktemp("wgsl")
    (folder / "stages.toml").write_text(TABLE, "utf-8")
    (folder / "paint.wgsl").write_text(STAGE, "utf-8")
    (folder / "self_test.wgsl").write_text((FOLDER / "self_test.wgsl").read_text("utf-8"), "utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GPU_XFORM_WGSL", str(folder))
        with GpuDevice() as device:
            yield device


def paint(
    device: GpuDevice,
    target: Texture,
    color: tuple[float, ...],
    write: ColorWrite = ColorWrite.REPLACE,
    *,
    extent: tuple[int, int] = EXTENT,
    first_vertex: int = 0,
    clear_color: tuple[float, float, float, float] | None = None,
) -> None:
    """Draw a quad of one colour."""
    uniform = Buffer(device.context, 16, UNIFORM, label="color")
    indices = Buffer(device.context, QUAD.nbytes, Usage.INDEX | Usage.COPY_DST, label="indices")
    uniform.upload(np.array(color, np.float32))
    indices.upload(QUAD)
    pipeline = device.pipelines.render("paint", target.format, write, factor=1.0)
    group = device.bind_groups.bind(pipeline, color=uniform)
    with (
        device.encode_commands(uniform, indices, label="test") as encoder,
        begin_render_pass(encoder, target, extent, pipeline, group, clear_color=clear_color) as render,
    ):
        render.draw_indexed(indices, len(QUAD), first_vertex)
    uniform.release()
    indices.release()


def read(device: GpuDevice, texture: Texture) -> Pixels:
    """Return the texels (height, width, 4)."""
    width, height = texture.extent
    row_bytes = align_row(4 * width)
    readback = Buffer(device.context, row_bytes * height, READBACK, label="readback")
    with device.encode_commands(readback, label="test") as encoder:
        encoder.copy_texture_to_buffer(texture, readback, texture.extent, row_bytes)
    with readback.map_read(readback.n_bytes) as view:
        pixels = view.reshape(height, row_bytes // 4, 4)[:, :width].copy()
    readback.release()
    return pixels


@pytest.fixture
def target(painter: GpuDevice) -> Iterator[Texture]:
    """A black texture, larger than what is drawn."""
    texture = Texture(painter.context, (10, 7), "rgba8unorm", label="target")
    paint(painter, texture, (0.0, 0.0, 0.0, 1.0), ColorWrite.NOTHING, clear_color=(0.0, 0.0, 0.0, 1.0))
    assert (read(painter, texture) == (0, 0, 0, 255)).all()
    yield texture
    texture.release()


def test_what_is_drawn_replaces_the_texels_of_its_viewport_alone(painter: GpuDevice, target: Texture) -> None:
    paint(painter, target, (1.0, 0.2, 0.0, 0.4))
    expected = np.full((7, 10, 4), (0, 0, 0, 255), np.uint8)
    expected[:4, :3] = (255, 51, 0, 102)
    assert (read(painter, target) == expected).all()


def test_indices_count_from_the_first_vertex(painter: GpuDevice, target: Texture) -> None:
    paint(painter, target, (1.0, 1.0, 1.0, 1.0), first_vertex=4)
    lit = read(painter, target)[..., 0] == 255
    assert lit[:4, 3:6].all()
    assert lit.sum() == 12


def test_three_vertices_are_a_triangle(painter: GpuDevice, target: Texture) -> None:
    uniform = Buffer(painter.context, 16, UNIFORM, label="color")
    uniform.upload(np.ones(4, np.float32))
    pipeline = painter.pipelines.render("paint", target.format, factor=1.0)
    group = painter.bind_groups.bind(pipeline, color=uniform)
    with (
        painter.encode_commands(uniform, label="test") as encoder,
        begin_render_pass(encoder, target, EXTENT, pipeline, group) as render,
    ):
        render.draw(3)
    uniform.release()
    lit = read(painter, target)[:4, :3, 0] == 255
    assert lit[0, 0]
    assert not lit[3, 2]


def test_products_of_what_is_left_do_not_replace(painter: GpuDevice, target: Texture) -> None:
    paint(painter, target, (0.0, 0.0, 0.0, 0.0), clear_color=(1.0, 1.0, 1.0, 1.0))
    paint(painter, target, (1.0, 1.0, 1.0, 1.0), first_vertex=0)
    for _ in range(2):
        paint(painter, target, (0.5, 0.25, 0.0, 1.0), ColorWrite.MULTIPLY_BY_REST)
    assert np.abs(read(painter, target)[:4, :3].astype(int) - (64, 143, 255, 0)).max() <= 1
    assert (read(painter, target)[:, 6:] == 255).all()


@pytest.mark.parametrize("texture_format", ["r32float", "r16float"])
def test_floats_hold_more_than_bytes(painter: GpuDevice, texture_format: str) -> None:
    if texture_format == "r32float" and "float32-blendable" not in painter.features:
        pytest.skip("the device does not blend single precision")
    texture = Texture(painter.context, (4, 4), texture_format, label="transmittance")
    paint(painter, texture, (0.0,) * 4, ColorWrite.NOTHING, extent=(4, 4), clear_color=(1.0, 1.0, 1.0, 1.0))
    for _ in range(8):
        paint(painter, texture, (0.75,) * 4, ColorWrite.MULTIPLY_BY_REST, extent=(4, 4))
    n_bytes, dtype = (4, np.float32) if texture_format == "r32float" else (2, np.float16)
    readback = Buffer(painter.context, 4 * 256, READBACK, label="readback")
    with painter.encode_commands(readback, label="test") as encoder:
        encoder.copy_texture_to_buffer(texture, readback, (4, 4), 256)
    with readback.map_read(4 * 256) as view:
        values = view.reshape(4, 256)[:, : 4 * n_bytes].copy().view(dtype)
    readback.release()
    texture.release()
    assert values[:, :2] == pytest.approx(0.25**8, rel=1e-3)
    assert (values[:, 2:] == 1.0).all()


def test_what_writes_nothing_leaves_all(painter: GpuDevice, target: Texture) -> None:
    paint(painter, target, (1.0, 1.0, 1.0, 0.0), ColorWrite.NOTHING)
    assert (read(painter, target) == (0, 0, 0, 255)).all()


def test_a_pipeline_is_compiled_once_for_each_format_write_and_choice_of_constants(painter: GpuDevice) -> None:
    render = painter.pipelines.render
    first = render("paint", "rgba8unorm", factor=1.0)
    assert render("paint", "rgba8unorm", ColorWrite.REPLACE, factor=1.0) is first
    others = [
        render("paint", "r16float", factor=1.0),
        render("paint", "rgba8unorm", ColorWrite.NOTHING, factor=1.0),
        render("paint", "rgba8unorm", ColorWrite.MULTIPLY_BY_REST, factor=1.0),
        render("paint", "rgba8unorm", factor=0.5),
    ]
    assert len({pipeline.id for pipeline in (first, *others)}) == 5
    painter.pipelines.reload()
    assert render("paint", "rgba8unorm", factor=1.0) is not first


def test_a_pipeline_that_is_refused_names_the_file_and_its_constants(painter: GpuDevice) -> None:
    with pytest.raises(ShaderError, match=r"^paint\.wgsl with \{'missing': 1\.0\} is refused: "):
        painter.pipelines.render("paint", "rgba8unorm", missing=1.0)
    with pytest.raises(ShaderError, match=r"^paint\.wgsl with \{'factor': 1\.0\} is refused: "):
        painter.pipelines.render("paint", "rgba8snorm", factor=1.0)


def test_a_closed_device_compiles_nothing() -> None:
    with GpuDevice() as other:
        pass
    with pytest.raises(DeviceError, match="closed"):
        other.pipelines.render("composite_triangles", "rgba8unorm", has_depth_cue=0, is_first=1)


def test_a_released_texture_is_neither_bound_nor_drawn_into(painter: GpuDevice) -> None:
    texture = Texture(painter.context, EXTENT, "rgba8unorm", label="gone")
    texture.release()
    with pytest.raises(DeviceError, match=r"^the texture 'gone' has been released$"):
        paint(painter, texture, (1.0, 1.0, 1.0, 1.0))


def test_textures_are_copied_row_by_row(painter: GpuDevice) -> None:
    texture, other = (Texture(painter.context, (5, 6), "rgba8unorm", label="copy") for _ in range(2))
    rows = np.zeros((4, 64, 4), np.uint8)
    rows[:, :5] = np.random.default_rng(0).integers(0, 256, (4, 5, 4))
    source = Buffer(painter.context, rows.nbytes, Usage.COPY_SRC | Usage.COPY_DST, label="rows")
    source.upload(rows)
    with painter.encode_commands(source, label="test") as encoder:
        encoder.copy_buffer_to_texture(source, texture, (5, 4), 256)
        encoder.copy_buffer_to_texture(source, texture, (3, 2), 256, 4)
        encoder.copy_texture(texture, other, (5, 6))
    copied = read(painter, other)
    assert (copied[:4] == rows[:, :5]).all()
    assert (copied[4:, :3] == rows[:2, :3]).all()
    source.release()
    texture.release()
    other.release()


def test_render_passes_are_timed_as_dispatches_are(painter: GpuDevice, target: Texture) -> None:
    with painter.time_dispatches() as timer:
        paint(painter, target, (1.0, 1.0, 1.0, 1.0))
        [time] = timer.times
    assert time.label == "paint"
    assert time.end_ns >= time.begin_ns
