"""`gpu-xform bench`: measurements as text and as JSON."""

import json
import re

import pytest

import gpu_xform as gx
from gpu_xform.cli import main
from tests.support.cli import error_of


@pytest.mark.float64
def test_bench_prints_figures_that_hang_together(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--points", "1000,20000", "--json", "--dtype", "float64"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["dtype"] == "float64"
    assert [size["n_points"] for size in report["sizes"]] == [1000, 20000]
    for size in report["sizes"]:
        assert size["n_bytes"] == 24 * size["n_points"]
        assert all(value > 0 for value in size.values())
        assert size["warm_gb_s"] == pytest.approx(2 * size["n_bytes"] / size["warm_ms"] / 1e6)
        assert size["percent_of_device_copy"] == pytest.approx(100 * size["device_copy_ms"] / size["kernel_ms"])
        assert size["times_host"] == pytest.approx(size["host_ms"] / size["warm_ms"])
        assert size["times_numpy"] == pytest.approx(size["numpy_ms"] / size["warm_ms"])


def test_bench_of_the_host_has_no_copies(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--points", "20000", "--json", "--adapter", "host"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["adapter"] == "host"
    (size,) = report["sizes"]
    on_device = {"upload_ms", "kernel_ms", "download_ms", "device_copy_ms", "kernel_gb_s", "percent_of_device_copy"}
    assert {name for name, value in size.items() if value is None} == on_device
    assert main(["bench", "--points", "20000", "--adapter", "host"]) == 0
    assert re.search(r"^  kernel, ms +-$", capsys.readouterr().out, re.MULTILINE)


def test_bench_says_when_the_device_is_a_cpu(capsys: pytest.CaptureFixture[str], device: gx.Device) -> None:
    assert main(["bench", "--points", "1e3"]) == 0
    printed = capsys.readouterr().out
    assert ("is a CPU, not a GPU" in printed) == (device.adapter.kind == "CPU")
    assert "the host device (--adapter host)" in printed.lower()
    assert re.search(r"^points +1,000$", printed, re.MULTILINE)


def test_bench_refuses_a_wrong_result(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("gpu_xform.diagnostics.bench.transform_points", lambda points, matrix, out, device: out.fill(0))  # noqa: ARG005
    assert "computes wrong results" in error_of(["bench", "--points", "1e3"], capsys, 1)


@pytest.mark.parametrize("text", ["0", "-5", "1.5", "many", "", "1e99", "nan"])
def test_bench_wants_whole_numbers_of_points(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--points" in error_of(["bench", f"--points={text}"], capsys)
