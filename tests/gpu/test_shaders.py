import itertools
import logging
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import DeviceError, ShaderError
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.wgsl import Sources
from tests.support.wgsl import FOLDER, STAGES, VARIANTS, copy_with, create_pipeline, source

# Squares modulo a prime p. Their cyclic shifts, and zeros, are a design of p + 1 rows (Plackett and Burman, 1946): for
# 7 they hold every combination of any two of 7 switches, for 11 those of any three of 11.
SQUARES = {7: {0, 1, 2, 4}, 11: {0, 1, 3, 4, 5, 9}}


def combinations_of_switches(n: int, n_together: int = 3) -> list[tuple[float, ...]]:
    """Return combinations of up to eight switches that hold every combination of any two or three, `n_together`."""
    if n <= n_together:
        return list(itertools.product((0.0, 1.0), repeat=n))
    p = {2: 7, 3: 11}[n_together]
    shifted = [tuple(float((column + row) % p in SQUARES[p]) for column in range(n)) for row in range(p)]
    return [(0.0,) * n, *shifted]


@pytest.mark.parametrize(("n", "n_together"), [(2, 3), (4, 3), (5, 3), (6, 3), (7, 3), (8, 3), (2, 2), (3, 2), (7, 2)])
def test_any_few_switches_have_every_combination(n: int, n_together: int) -> None:
    combinations = combinations_of_switches(n, n_together)
    for chosen in itertools.combinations(range(n), min(n, n_together)):
        assert len({tuple(each[i] for i in chosen) for each in combinations}) == 2 ** len(chosen)


def choices(stage: str, n_together: int = 3) -> Iterator[dict[str, float]]:
    """Yield combinations of a stage's boolean constants, and each value of those that take a few only."""
    row = STAGES[stage]
    names = [name for constants in row.overrides.values() for name in constants]
    first = dict.fromkeys(names, 1.0) | {name: float(values[0]) for name, values in row.values.items()}
    switches = row.overrides.get("bool", ())
    for combination in combinations_of_switches(len(switches), n_together):
        yield first | dict(zip(switches, combination, strict=True))
    for name, values in row.values.items():
        for value in values[1:]:
            yield first | {name: float(value)}


@pytest.mark.slow
@pytest.mark.parametrize(("stage", "number_type"), VARIANTS)
def test_every_stage_compiles_for_its_constants(stage: str, number_type: str | None, device: GpuDevice) -> None:
    if number_type == "f64" and not device.has_float64:
        with pytest.raises(ShaderError):
            device.pipelines.module(stage, number_type)
        return
    # The text for double precision is that for single, so that fewer switches are tried together.
    for constants in choices(stage, 2 if number_type == "f64" else 3):
        pipeline = create_pipeline(device, stage, number_type, constants)
        assert pipeline.bindings == source(stage, number_type).bindings


@pytest.mark.parametrize("wrong", ["cue.distance_scale * true", "cue.distance_scale * ;", "cue.distance_scale * width"])
def test_a_shader_that_does_not_compile_names_the_file_and_line_where_it_is_wrong(
    wrong: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = copy_with(tmp_path, "shared/depth_cue.wgsl", "cue.distance_scale * w", wrong)
    lines = (folder / "shared" / "depth_cue.wgsl").read_text("utf-8").splitlines()
    [number] = [number for number, line in enumerate(lines, 1) if wrong in line]
    monkeypatch.setenv("GPU_XFORM_WGSL", str(folder))
    message = rf"^shared/depth_cue\.wgsl:{number} does not compile on Device\("
    with GpuDevice() as other:
        for stage in ("accumulate_lines", "depth_small_triangles"):
            with pytest.raises(ShaderError, match=message) as seen:
                other.pipelines.module(stage)
            assert "┌─ shared/depth_cue.wgsl:" in str(seen.value)
            assert f"\n{number} " in str(seen.value)
            assert wrong in str(seen.value)


def test_a_pipeline_that_is_refused_names_the_file_and_its_constants(device: GpuDevice) -> None:
    with pytest.raises(ShaderError, match=r"^self_test\.wgsl with \{'missing': 1\.0\} is refused"):
        device.pipelines.compute("self_test", missing=1.0)


def test_a_message_without_a_place_is_left_as_it_is() -> None:
    assert source("self_test").relocate("out of memory") == ("out of memory", None)
    assert source("self_test").relocate("┌─ wgsl:100000:1\n") == ("┌─ wgsl:100000:1\n", None)


def test_a_pipeline_is_compiled_once_for_each_choice_of_its_constants(device: GpuDevice) -> None:
    compute = device.pipelines.compute
    first = compute("transform_in_place", "f32", workgroup_size=64, n_components=3, epilogue=1)
    assert compute("transform_in_place", "f32", epilogue=1, n_components=3, workgroup_size=64) is first
    assert compute("transform_in_place", "f32", workgroup_size=64, n_components=3, epilogue=0) is not first
    assert compute("transform_in_place", "f32", workgroup_size=32, n_components=3, epilogue=1) is not first


def test_a_closed_device_compiles_nothing() -> None:
    with GpuDevice() as other:
        pass
    with pytest.raises(DeviceError, match="closed"):
        other.pipelines.compute("self_test")


def touch(file: Path) -> None:
    """Give a file a new time of change, however coarse the file system's clock is."""
    later = time.time_ns() + 2_000_000_000
    os.utime(file, ns=(later, later))


def test_a_shader_of_another_folder_is_read_again_when_it_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = copy_with(tmp_path, "self_test.wgsl", "", "")
    file = folder / "self_test.wgsl"
    right = file.read_text("utf-8")
    monkeypatch.setenv("GPU_XFORM_WGSL", str(folder))
    with GpuDevice() as other:
        first = other.pipelines.compute("self_test")
        assert other.pipelines.compute("self_test") is first
        file.write_text(right.replace("fn main() {", "fn main() { wrong"), "utf-8")
        touch(file)
        with pytest.raises(ShaderError, match=r"^self_test\.wgsl:\d+ does not compile"):
            other.pipelines.compute("self_test")
        file.write_text(right, "utf-8")
        touch(file)
        again = other.pipelines.compute("self_test")
        assert again is not first
        assert again.id != first.id
        assert other.pipelines.compute("self_test") is again


def test_the_next_picture_is_drawn_by_the_shader_as_it_is_now(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = copy_with(tmp_path, "self_test.wgsl", "", "")
    file = folder / "raster" / "composite_lines.wgsl"
    monkeypatch.setenv("GPU_XFORM_WGSL", str(folder))
    with GpuDevice() as other:
        options: dict[str, Any] = {"device": other, "size": (40, 40), "line_width": 3.0, "edges": "all"}
        black = gx.render_array(gx.samples.cube(), **options)
        assert (black[..., :3] == 0).all(axis=2).any()
        text = file.read_text("utf-8")
        assert "vec4(style.color.rgb, 1.0)" in text
        file.write_text(text.replace("vec4(style.color.rgb, 1.0)", "vec4(1.0, style.color.gb, 1.0)"), "utf-8")
        touch(file)
        red = gx.render_array(gx.samples.cube(), **options)
    np.testing.assert_array_equal(red[..., 1:], black[..., 1:])
    assert (red[..., 0] == 255).all()


def test_reloading_compiles_anew(device: GpuDevice) -> None:
    first = device.pipelines.compute("self_test")
    device.pipelines.reload()
    assert device.pipelines.compute("self_test") is not first


def test_the_packages_own_files_are_not_watched(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Sources) -> bool:
        raise AssertionError("looked for changes")

    monkeypatch.setattr(Sources, "have_changed", refuse)
    assert device.pipelines.compute("self_test").label == "self_test"


def test_debugging_writes_what_is_compiled_with_the_origin_of_each_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("GPU_XFORM_DEBUG", "1")
    monkeypatch.setenv("GPU_XFORM_DEBUG_DIR", str(tmp_path / "dump"))
    with caplog.at_level(logging.WARNING), GpuDevice() as other:
        other.pipelines.module("transform_points", "f32")
    assert [record.getMessage() for record in caplog.records] == [f"resolved WGSL is written to {tmp_path / 'dump'}"]
    assert {file.name for file in (tmp_path / "dump").iterdir()} == {
        f"{name}.{kind}" for name in ("self_test", "transform_points_f32") for kind in ("wgsl", "lines")
    }
    code = (tmp_path / "dump" / "transform_points_f32.wgsl").read_text("utf-8").splitlines()
    for line in (tmp_path / "dump" / "transform_points_f32.lines").read_text("utf-8").splitlines():
        number, place = line.split("\t")
        file, own_number = place.split(":")
        assert (FOLDER / file).read_text("utf-8").splitlines()[int(own_number) - 1] == code[int(number) - 1]


def test_debugging_without_a_folder_makes_one_and_says_which(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("GPU_XFORM_DEBUG", "1")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with GpuDevice():
        pass
    [folder] = [path for path in tmp_path.iterdir() if (path / "self_test.wgsl").is_file()]
    assert caplog.messages == [f"resolved WGSL is written to {folder}"]
