"""Workloads: edges counted, and their lengths in pixels."""

import contextlib
from typing import Any, cast

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, PointBuffer, samples
from gpu_xform.drawing.prepare import Frame, prepare_frame
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.workload import FALLBACK_LENGTH_PX, estimate_workload

CAMERA = Camera.window((0.0, 300.0), (0.0, 200.0))  # a unit is a pixel


def workload(device: GpuDevice, models: Any, camera: Any = CAMERA, **style: Any) -> Any:
    with contextlib.ExitStack() as stack:
        frame = stack.enter_context(
            prepare_frame(models, Frame(camera, (300, 200), "white", device), cast("Any", style))
        )
        return estimate_workload(frame.draw_list.drawables, frame.view.size)


def segments(n: int, length: float) -> Mesh:
    positions = np.zeros((2 * n, 3))
    positions[:, 1] = np.repeat(np.linspace(10.0, 190.0, n), 2)
    positions[1::2, 0] = length
    return Mesh(positions, np.arange(2 * n).reshape(-1, 2))


def test_edges_of_one_length_have_it(device: GpuDevice) -> None:
    assert workload(device, segments(7, 40.0)) == (7, pytest.approx(40.0))
    assert workload(device, segments(5000, 3.0)) == (5000, pytest.approx(3.0))


def test_the_mean_goes_over_layers_and_instances(device: GpuDevice) -> None:
    instances = np.stack([gx.translate(0, 0, 0), gx.translate(5, 0, 0), gx.translate(9, 0, 0)])
    layers = [Layer(segments(10, 20.0), transform=instances), Layer(segments(10, 100.0))]
    assert workload(device, layers) == (40, pytest.approx((30 * 20.0 + 10 * 100.0) / 40))


def test_a_sample_of_a_curved_model_is_near_the_mean_of_all(device: GpuDevice) -> None:
    mesh = samples.icosphere(4)
    found = workload(device, mesh, Camera.window((-1.5, 1.5), (-1.0, 1.0)))
    spans = 100.0 * np.diff(mesh.positions[mesh.edges][..., :2], axis=1)[:, 0]
    assert found == (len(mesh.edges), pytest.approx(np.hypot(*spans.T).mean(), rel=0.1))


def test_dots_have_no_length_and_edges_of_points_on_the_device_a_guess(device: GpuDevice) -> None:
    points = segments(4, 50.0).positions
    assert workload(device, points, point_size=3.0) == (8, 0.0)
    assert workload(device, segments(4, 50.0), point_size=3.0) == (12, pytest.approx(50.0 * 4 / 12))
    with PointBuffer(points.astype(np.float32), device=device) as buffer:
        assert workload(device, buffer, edges=[(0, 1), (2, 3)]) == (2, FALLBACK_LENGTH_PX)


def test_edges_behind_the_eye_are_left_out_and_long_ones_count_as_the_diagonal(device: GpuDevice) -> None:
    eye = Camera.look_at((0, 0, 1), (0, 0, 0), fov_y=90.0, near=0.1, far=10.0)
    beside_and_behind = Mesh([(0, 0, 0), (1, 0, 0), (0, 0, 2), (1, 0, 2)], [(0, 1), (2, 3)])
    assert workload(device, beside_and_behind, eye) == (2, pytest.approx(100.0))
    assert workload(device, segments(3, 1e7)) == (3, pytest.approx(np.hypot(300, 200)))
