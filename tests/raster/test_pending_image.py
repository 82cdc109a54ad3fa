"""Pictures that are drawn while those before them are read."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from gpu_xform import ArgumentError, DeviceError, Mesh, render_array, rotate, samples
from gpu_xform.drawing.prepare import Frame
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster import rasterizer
from gpu_xform.raster.base import PendingImage
from gpu_xform.raster.render_target import RenderTarget
from gpu_xform.rendering.raster import begin_render

STYLES: dict[str, dict[str, Any]] = {
    "one colour": {},
    "by face": {"color": "face", "line_width": 2.5},
    "on or off": {"antialias": False},
    "filled": {"hidden": "remove", "fill": "face"},
}
MOVED = [samples.cube().transformed(rotate((1, 2, 3), 0.3 * k)) for k in range(5)]


@pytest.fixture(params=["default", "staging"])
def options(request: pytest.FixtureRequest, device: GpuDevice, staging_device: GpuDevice) -> dict[str, Any]:
    return {"size": (90, 70), "device": device if request.param == "default" else staging_device}


@pytest.fixture(params=[2048, 32])
def _small_tiles(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rasterizer, "TILE_SIDE_PX", request.param)


NO_STYLE: Any = {}


def begin(
    model: Mesh, options: dict[str, Any], style: Any = NO_STYLE, *, overlap_with: PendingImage | None = None
) -> PendingImage:
    return begin_render(model, Frame(**options), style, overlap_with=overlap_with)


@pytest.mark.slow
@pytest.mark.usefixtures("_small_tiles")
@pytest.mark.parametrize("style", STYLES.values(), ids=list(STYLES))
def test_overlapping_pictures_are_what_each_would_be(style: dict[str, Any], options: dict[str, Any]) -> None:
    models = MOVED[:3]
    expected = [render_array(model, **options, **style) for model in models]
    assert len({pixels.tobytes() for pixels in expected}) == len(models)
    before = begin(models[0], options, style)
    for k in range(1, len(models)):
        following = begin(models[k], options, style, overlap_with=before)
        assert before.result().tobytes() == expected[k - 1].tobytes()
        before = following
    assert before.result().tobytes() == expected[-1].tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("style", STYLES.values(), ids=list(STYLES))
def test_pictures_can_be_read_in_any_order(style: dict[str, Any], options: dict[str, Any]) -> None:
    expected = [render_array(model, **options, **style) for model in MOVED]
    pending = [begin(model, options, style) for model in MOVED]
    other = render_array(samples.house(), **options, **style)
    for k in (3, 0, 4, 1, 2):
        assert pending[k].result().tobytes() == expected[k].tobytes()
    assert render_array(samples.house(), **options, **style).tobytes() == other.tobytes()


def test_a_picture_that_fails_leaves_the_one_before_to_be_read(options: dict[str, Any]) -> None:
    expected = render_array(MOVED[1], **options)
    before = begin(MOVED[1], options)
    with pytest.raises(ArgumentError, match="line_width"):
        begin(MOVED[2], options, {"line_width": -1.0}, overlap_with=before)
    assert before.result().tobytes() == expected.tobytes()


def test_a_picture_that_is_never_read_does_not_affect_others(options: dict[str, Any]) -> None:
    expected = render_array(MOVED[1], **options)
    for _ in range(4):
        begin(MOVED[2], options, overlap_with=begin(MOVED[3], options))
    assert render_array(MOVED[1], **options).tobytes() == expected.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("style", STYLES.values(), ids=list(STYLES))
def test_pictures_drawn_in_several_threads_are_what_each_would_be(
    style: dict[str, Any], options: dict[str, Any]
) -> None:
    expected = [render_array(model, **options, **style).tobytes() for model in MOVED]
    with ThreadPoolExecutor(len(MOVED)) as pool:
        for _ in range(4):
            drawn = pool.map(lambda model: render_array(model, **options, **style).tobytes(), MOVED)
            assert list(drawn) == expected


def spare(device: GpuDevice) -> list[int]:
    """Return the numbers of the buffers that a device has for pictures."""
    return sorted(buffer.id for buffers in device.pool._spare.values() for buffer in buffers)


@pytest.mark.parametrize("has_arrived", [False, True])
def test_a_cancelled_picture_releases_its_memory(options: dict[str, Any], has_arrived: bool) -> None:
    expected = render_array(MOVED[1], **options)
    for _ in range(4):
        before = spare(options["device"])
        pending = begin(MOVED[2], options)
        if has_arrived:
            pending.wait()
        assert spare(options["device"]) != before
        pending.cancel()
        pending.cancel()
        assert spare(options["device"]) == before
        assert render_array(MOVED[1], **options).tobytes() == expected.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["collected", "recorded"])
@pytest.mark.parametrize("n_before", [0, 1, 2])
def test_a_picture_that_fails_releases_its_memory(
    options: dict[str, Any], monkeypatch: pytest.MonkeyPatch, stage: str, n_before: int
) -> None:
    monkeypatch.setattr(rasterizer, "TILE_SIDE_PX", 32)
    owner, name = (rasterizer, "_collect") if stage == "collected" else (RenderTarget, "resolve")
    whole, calls = getattr(owner, name), []

    def sometimes(*args: Any) -> Any:
        calls.append(args)
        if len(calls) > n_before:
            raise MemoryError("no room")
        return whole(*args)

    for model in MOVED:
        render_array(model, **options)
    before = spare(options["device"])
    monkeypatch.setattr(owner, name, sometimes)
    with pytest.raises(MemoryError, match="no room"):
        begin(MOVED[0], options)
    assert spare(options["device"]) == before


def test_a_picture_of_a_closed_device_can_be_cancelled() -> None:
    with GpuDevice() as own:
        pending = begin(MOVED[0], {"device": own, "size": (90, 70)})
    pending.cancel()


def test_a_picture_can_be_read_again(options: dict[str, Any]) -> None:
    pending = begin(MOVED[1], options)
    first = pending.result().tobytes()
    others = [begin(model, options) for model in MOVED[2:]]
    assert pending.result().tobytes() == first
    for model, other in zip(MOVED[2:], others, strict=True):
        assert other.result().tobytes() == render_array(model, **options).tobytes()


def test_several_pictures_can_overlap_one_and_one_that_has_been_read(options: dict[str, Any]) -> None:
    expected = [render_array(model, **options).tobytes() for model in MOVED]
    before = begin(MOVED[0], options)
    following = [begin(model, options, overlap_with=before) for model in MOVED[1:3]]
    assert before.result().tobytes() == expected[0]
    following += [begin(model, options, overlap_with=before) for model in MOVED[3:]]
    assert [pending.result().tobytes() for pending in following] == expected[1:]


def test_a_picture_may_overlap_one_of_another_device(device: GpuDevice, staging_device: GpuDevice) -> None:
    expected = render_array(MOVED[1], device=device, size=(90, 70))
    before = begin(MOVED[2], {"device": staging_device, "size": (90, 70)})
    assert (
        begin(MOVED[1], {"device": device, "size": (90, 70)}, overlap_with=before).result().tobytes()
        == expected.tobytes()
    )
    assert before.result().tobytes() == render_array(MOVED[2], device=staging_device, size=(90, 70)).tobytes()


@pytest.mark.parametrize("has_arrived", [False, True])
def test_a_picture_of_a_closed_device_is_a_device_error(has_arrived: bool) -> None:
    with GpuDevice() as own:
        pending = begin(MOVED[0], {"device": own, "size": (90, 70)})
        if has_arrived:
            begin(MOVED[1], {"device": own, "size": (90, 70)}, overlap_with=pending)
    with pytest.raises(DeviceError, match="closed"):
        pending.result()
