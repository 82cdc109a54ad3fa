import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import wgpu

import gpu_xform
from gpu_xform.cli import main
from gpu_xform.compute import transform
from gpu_xform.compute.kernels.job import Job
from gpu_xform.diagnostics import doctor, doctor_report
from gpu_xform.diagnostics.doctor import examine
from gpu_xform.diagnostics.doctor_report import Check, Report
from gpu_xform.errors import DeviceError
from gpu_xform.gpu import self_test
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster import rasterizer

NO_DRIVER = {"VK_DRIVER_FILES": os.devnull, "VK_ICD_FILENAMES": os.devnull}
PICTURES = ["picture (render)", "picture (compute)"]
CHECKS = ["matrix layout", "struct layout", "long loop", "float32 transform", "float64 transform", *PICTURES]


@pytest.fixture(scope="module")
def report() -> Report:
    return examine()


def wrong(checks: tuple[Check, ...]) -> list[str]:
    return [check.name for check in checks if not check.passed]


def test_this_machine_is_well(report: Report, device: GpuDevice) -> None:
    assert report.passed
    assert report.device == device.adapter
    assert report.adapters == tuple(gpu_xform.adapters())
    assert [check.name for check in report.checks] == [n for n in CHECKS if device.has_float64 or "64" not in n]
    assert report.versions["gpu_xform"] == gpu_xform.__version__
    assert report.versions["wgpu"] == wgpu.__version__
    assert report.versions["numpy"] == np.__version__


def test_the_command_prints_the_report(report: Report, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    assert capsys.readouterr() == (report.text(), "")
    assert main(["doctor", "--json"]) == 0
    parsed = json.loads(capsys.readouterr().out)
    assert parsed["passed"] is True
    assert parsed["device"]["features"] == sorted(report.adapters[0].features)
    assert parsed["checks"] == [dataclasses.asdict(check) for check in report.checks]


def test_the_text_says_what_matters(report: Report) -> None:
    text = report.text()
    assert report.device is not None
    for piece in (*report.versions.values(), report.device.name, report.device.driver, report.device.backend):
        assert piece in text
    assert "  float64 " in text
    assert ("This device is a CPU" in text) == (report.device.kind == "CPU")
    assert "the host device (--adapter host)" in text.lower()
    assert text.endswith("Everything works.\n")
    assert max(map(len, text.splitlines())) <= max(80, *(len(line) + 11 for line in report.versions.values()))


def test_a_gpu_is_not_called_a_cpu(report: Report) -> None:
    assert report.device is not None
    gpu = dataclasses.replace(report.device, kind="DiscreteGPU", features=frozenset())
    text = dataclasses.replace(report, device=gpu, adapters=(gpu,)).text()
    assert "is a CPU" not in text
    for feature in ("float64", "host-mappable memory", "timestamps"):
        assert f"{feature:26} no\n" in text


def off_by_little(points: npt.NDArray[Any], matrix: npt.NDArray[Any], out: npt.NDArray[Any]) -> None:
    out[:] = points @ matrix[:3, :3].T + matrix[:3, 3]
    out[500, 1] *= 1 + 1e-5 if out.dtype == np.float32 else 1 + 1e-12


def transposed(points: npt.NDArray[Any], matrix: npt.NDArray[Any], out: npt.NDArray[Any]) -> None:
    out[:] = points @ matrix[:3, :3] + matrix[:3, 3]


def in_single_precision(points: npt.NDArray[Any], matrix: npt.NDArray[Any], out: npt.NDArray[Any]) -> None:
    single = matrix.astype(np.float32)
    out[:] = points.astype(np.float32) @ single[:3, :3].T + single[:3, 3]


def one_left_out(points: npt.NDArray[Any], matrix: npt.NDArray[Any], out: npt.NDArray[Any]) -> None:
    out[:-1] = points[:-1] @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize(
    ("mutant", "failing"),
    [
        (off_by_little, ["float32 transform", "float64 transform"]),
        (transposed, ["float32 transform", "float64 transform"]),
        (in_single_precision, ["float64 transform"]),
        (one_left_out, ["float32 transform", "float64 transform"]),
    ],
)
def test_a_wrong_transform_is_noticed(
    mutant: Callable[..., None],
    failing: list[str],
    device: GpuDevice,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def run(job: Job) -> None:
        mutant(job.points, job.matrices[0], job.out[0])

    monkeypatch.setattr(transform, "find_backend", lambda _: SimpleNamespace(run_transform=run))
    assert wrong(examine().checks) == [n for n in failing if device.has_float64 or "64" not in n]
    if device.has_float64:
        assert main(["doctor"]) == 1
        printed = capsys.readouterr().out
        assert "  WRONG  float64 transform " in printed
        assert printed.endswith("This device cannot be relied on.\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    "mutant",
    [
        np.zeros_like,
        lambda pixels: pixels * np.array([0, 0, 0, 1], np.uint8),
        lambda pixels: np.full_like(pixels, 255),
        lambda pixels: pixels[::-1],
        lambda pixels: pixels[:, ::-1],
        lambda pixels: pixels.swapaxes(0, 1),
        lambda pixels: pixels // 2,
    ],
)
def test_a_wrong_picture_is_noticed(
    mutant: Callable[[npt.NDArray[np.uint8]], npt.NDArray[np.uint8]], monkeypatch: pytest.MonkeyPatch
) -> None:
    result = rasterizer.TiledPendingImage.result
    monkeypatch.setattr(rasterizer.TiledPendingImage, "result", lambda pending: mutant(result(pending)))
    assert wrong(examine().checks) == PICTURES
    assert main(["doctor"]) == 1


def test_a_device_that_fails_while_it_works_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: object, **__: object) -> None:
        raise DeviceError("the device is lost")

    monkeypatch.setattr(rasterizer.TiledRasterizer, "draw", lost)
    report = examine()
    assert wrong(report.checks) == PICTURES
    assert "WRONG  picture (render)  the device is lost\n" in report.text()
    assert report.render_passes[0] == "render pass: WRONG, the device is lost"


def test_each_adapter_has_a_line_about_what_a_render_pass_drew_on_it(
    report: Report, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert report.device is not None
    drawn = "render pass: ok, 32 of 32 pixels lit, 904 of 904 unlit"
    assert report.render_passes == (drawn,) * len(report.adapters)
    assert report.text().count(f"    {drawn}\n") == len(report.adapters)
    other = dataclasses.replace(report.device, driver="another driver")
    monkeypatch.setattr(doctor, "adapters", lambda: [report.device, other])
    assert examine().render_passes == (drawn, drawn)
    broken = dataclasses.replace(other, name="no such adapter")
    monkeypatch.setattr(doctor, "adapters", lambda: [broken, report.device])
    found = examine()
    assert found.passed
    assert found.render_passes[0].startswith(
        "render pass: WRONG, no graphics adapter has 'no such adapter' in its name"
    )
    assert found.render_passes[1] == drawn


def test_a_device_without_the_texture_format_is_told_what_to_choose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu_xform.raster.hardware.lines.transmittance_format", lambda _: "rgba8snorm")
    report = examine()
    assert wrong(report.checks) == ["picture (render)"]
    for place in (report.text(), *report.render_passes):
        assert "cannot draw lines into a texture of rgba8snorm, which rasterizer='compute' does without" in place


def test_a_device_that_does_not_open_is_reported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(self_test, "run", lambda *_: [("long loop", False, "counted to 7")])
    report = examine()
    assert wrong(report.checks) == ["open the device"]
    assert report.device is not None
    assert main(["doctor"]) == 1
    assert "long loop (counted to 7)" in capsys.readouterr().out


def test_the_reason_for_the_choice(
    report: Report, device: GpuDevice, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    part = device.name[:4]
    monkeypatch.setattr(doctor, "_run_checks", lambda _: ())
    monkeypatch.delenv("GPU_XFORM_ADAPTER", raising=False)
    n_adapters = len(report.adapters)
    assert examine().reason.startswith("it is the only one" if n_adapters == 1 else "it is the fastest kind of ")
    monkeypatch.setattr(doctor, "adapters", lambda: 3 * list(report.adapters))
    assert examine().reason.startswith(f"it is the fastest kind of {3 * n_adapters}")
    monkeypatch.setenv("GPU_XFORM_ADAPTER", part)
    assert examine().reason == f"GPU_XFORM_ADAPTER is {part!r}"
    assert examine(part.upper()).reason == f"{part.upper()!r} is requested"
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "nonesuch")
    assert examine().device is None
    assert main(["doctor"]) == 3
    printed = capsys.readouterr().out
    assert "no graphics adapter has 'nonesuch' in its name" in printed
    assert device.name in printed


@pytest.mark.parametrize("variable", [None, "HOST"])
def test_the_host_device_is_examined(
    variable: str | None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if variable:
        monkeypatch.setenv("GPU_XFORM_ADAPTER", variable)
    assert main(["doctor", *([] if variable else ["--adapter", "host"])]) == 0
    text = capsys.readouterr().out
    assert "In use: the host device, numba " in text
    assert ("GPU_XFORM_ADAPTER is 'HOST'" if variable else "'host' is requested") in text
    assert [line.split()[1] for line in text.splitlines() if line.startswith("  ok ")] == ["float32", "float64"]
    assert text.endswith("Everything works.\n")


def test_nothing_passes_without_checks(report: Report) -> None:
    assert not dataclasses.replace(report, checks=()).passed
    assert not dataclasses.replace(report, device=None).passed
    assert not dataclasses.replace(report, checks=(*report.checks, Check("x", False, ""))).passed


@pytest.mark.slow
def test_without_a_driver_the_report_says_what_to_install() -> None:
    typed = [sys.executable, "-m", "gpu_xform", "doctor"]
    result = subprocess.run(typed, capture_output=True, check=False, text=True, env=os.environ | NO_DRIVER)
    assert (result.returncode, result.stderr) == (3, "")
    assert "No adapters.\n" in result.stdout
    assert "nstall" in result.stdout
    assert "Checks" not in result.stdout


@pytest.mark.parametrize(
    ("n_bytes", "text"),
    [
        (0, "0 bytes"),
        (1023, "1023 bytes"),
        (1024, "1 KiB"),
        (1536, "1.5 KiB"),
        (128 << 20, "128 MiB"),
        ((1 << 31) - 1, "2 GiB"),
        (1000 << 20, "1000 MiB"),
        ((1 << 40) - 1, "1 TiB"),
        ((1 << 64) - 1, "16 EiB"),
    ],
)
def test_bytes_in_human_units(n_bytes: int, text: str) -> None:
    assert doctor_report._format_bytes(n_bytes) == text


@pytest.mark.parametrize("driver", ["", " ", ", "])
def test_a_driver_without_a_version_leaves_no_comma_behind(report: Report, device: GpuDevice, driver: str) -> None:
    adapter = dataclasses.replace(device.adapter, driver=driver)
    lines = dataclasses.replace(report, adapters=(adapter,)).text().splitlines()
    assert f"    {adapter.kind}, {adapter.backend}" in lines
