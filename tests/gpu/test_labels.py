"""Every object that wgpu makes for us has a label, and what wgpu says of it shows the label."""

import sys
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import DeviceError
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice

CREATORS = [
    *("create_buffer", "create_shader_module", "create_compute_pipeline", "create_bind_group"),
    *("create_command_encoder", "create_query_set"),
]


def test_every_object_has_a_label(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    made: dict[str, list[str]] = {name: [] for name in CREATORS}

    def spy_on(name: str) -> None:
        create = getattr(type(device.context.handle), name)

        def spy(*arguments: Any, **options: Any) -> Any:
            if sys._getframe(1).f_globals["__name__"].startswith("gpu_xform."):  # wgpu makes some for itself
                made[name].append(options.get("label", ""))
            return create(*arguments, **options)

        monkeypatch.setattr(type(device.context.handle), name, spy)

    for name in CREATORS:
        spy_on(name)
    with GpuDevice() as fresh:
        assert fresh.context.handle.label
        gx.render_array(gx.samples.cube(), hidden="remove", fill="gold", size=(64, 64), device=fresh)
        gx.render_svg(gx.samples.cube(), hidden="dash", edges="silhouette", device=fresh)
        gx.bounds(np.ones((5, 3), np.float32), device=fresh)
        gx.transform_points(np.ones((2, 5, 3), np.float32), np.stack([gx.identity()] * 2), device=fresh)
        if "timestamp-query" in fresh.features:
            with fresh.time_dispatches():
                gx.transform_points(np.ones((5, 3), np.float32), gx.identity(), device=fresh)
        else:
            made["create_query_set"].append("none")
    for name, labels in made.items():
        assert labels, name
        assert all(labels), name


def test_a_validation_error_shows_the_labels(device: GpuDevice) -> None:
    small = Buffer(device.context, 16, label="the small one")
    large = Buffer(device.context, 64, label="the large one")
    with (
        pytest.raises(DeviceError, match=r"record the commands \('the copy', 'the small one', 'the large one'\): "),
        device.encode_commands(small, large, label="the copy") as encoder,
    ):
        encoder.copy_buffer(large, small, 64)
    with pytest.raises(DeviceError, match=r"bind the buffers \('self_test', 'the small one', 'the large one'\): "):
        device.bind_groups.bind(device.pipelines.compute("self_test"), given=small, seen=large)
    small.release()
    large.release()
