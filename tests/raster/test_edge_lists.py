"""Edges that faces hide altogether are not drawn, and nothing else changes."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, samples
from gpu_xform.gpu import debug
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.compute import seen_edges
from gpu_xform.raster.hardware import edge_lists
from gpu_xform.raster.line_stage import BLOCK_EDGES, MIN_LISTED_EDGES
from tests.support.types import Pixels
from tests.support.wgsl import constants, struct

SIZE = (256, 192)
TORUS = samples.torus(48, 24)
FRAME: dict[str, Any] = {"size": SIZE, "rasterizer": "render", "hidden": "remove"}
ROW = np.stack([gx.translate(1.5 * k, 0.2 * k, -0.5 * k) for k in range(3)])

PICTURES: dict[str, tuple[Any, dict[str, Any]]] = {
    "one colour": (TORUS, {}),
    "dense": (samples.icosphere(5), {}),
    "dense in two": ([samples.icosphere(5), samples.torus(100, 60)], {"alpha": 0.4}),
    "thick and faint": (TORUS, {"line_width": 7.0, "alpha": 0.3}),
    "depth cue": (TORUS, {"depth_cue": 0.8}),
    "by face": (TORUS, {"color": "face", "line_width": 3.0}),
    "silhouette": (samples.icosphere(4), {"edges": "silhouette", "line_width": 3.0}),
    "instances": (samples.icosphere(2), {"transform": ROW, "color": "blue"}),
    "instances by height": (TORUS, {"transform": ROW, "scalars": TORUS.positions[:, 1]}),
    "tiles": (TORUS, {"size": (700, 530)}),
    "filled": (TORUS, {"fill": "gold"}),
    "two layers": ([Layer(TORUS, color="red"), Layer(samples.icosphere(3), line_width=4.0)], {}),
    "long edges": (samples.cube(), {"line_width": 3.0}),
    "close": (samples.icosphere(3), {"camera": Camera.look_at((0.0, 0.3, 1.2), (0.0, 0.0, 0.0))}),
}


def draw(monkeypatch: pytest.MonkeyPatch, min_edges: int, model: Any, style: dict[str, Any], device: Any) -> Pixels:
    for module in (edge_lists, seen_edges):
        monkeypatch.setattr(module, "MIN_LISTED_EDGES", min_edges)
    monkeypatch.setattr(seen_edges, "MAX_PIXELS_PER_EDGE", 1 << 40)
    return gx.render_array(model, device=device, **FRAME | style)


@pytest.mark.parametrize("name", PICTURES)
def test_a_list_changes_no_byte(
    name: str, rasterizer_name: str, monkeypatch: pytest.MonkeyPatch, device_with_limits: Any
) -> None:
    model, style = PICTURES[name]
    style = style | {"rasterizer": rasterizer_name}
    device = device_with_limits(max_texture_side=256)
    expected = draw(monkeypatch, 1 << 40, model, style, device)
    assert (expected != expected[0, 0]).any()
    assert draw(monkeypatch, 1, model, style, device).tobytes() == expected.tobytes()


def test_both_sides_count_alike() -> None:
    numbers = constants("mark_edges")
    assert numbers["BLOCK_EDGES"] == f"{BLOCK_EDGES}u"
    assert numbers["N_LISTS"] == f"{edge_lists.N_LISTS}u"
    assert 1 << int(numbers["LOG2_FANOUT"].rstrip("u")) == edge_lists.FANOUT
    assert struct("list_edges", "IndexedDraw").count(": u32,") * edge_lists.NUMBER_BYTES == edge_lists.DRAW_BYTES


def read_lists(device: GpuDevice) -> list[npt.NDArray[np.int64]]:
    """Return the edges of each list that was made last."""
    edges = debug.read_buffer(device, "raster: edge list", np.uint32).astype(np.int64)
    draws = debug.read_buffer(device, "raster: edge draws", np.uint32).reshape(-1, edge_lists.N_LISTS, 5)
    lists = []
    for own in draws.transpose(1, 0, 2):
        slices = [edges[first // 4 :][: n // 6] for n, n_instances, _, first, _ in own if n_instances and n]
        lists.append(np.concatenate([np.empty(0, np.int64), *slices]))
    return lists


@pytest.mark.parametrize(("level", "n_instances"), [(6, 1), (5, 3)])
def test_the_edges_towards_the_eye_are_listed_in_their_order(level: int, n_instances: int) -> None:
    """What faces away is not; of the rest most are known to be shown. There are several groups of groups."""
    eye = np.array((0.0, 0.0, 50.0))
    mesh = samples.icosphere(level)
    middles = mesh.positions[mesh.edges].mean(axis=1)
    offsets = 3.0 * np.arange(n_instances) - 1.5 * (n_instances - 1)
    stack = np.stack([gx.translate(float(x), 0.0, 0.0) for x in offsets])
    camera = Camera.look_at(tuple(eye), (0.0, 0.0, 0.0), fov_y=10.0)
    with GpuDevice() as device:
        gx.render_array(mesh, device=device, camera=camera, transform=stack, **FRAME | {"size": (512, 512)})
        shown, unknown = read_lists(device)
    # Of a point of a unit sphere: how far it lies before the plane through the points that the eye sees at the rim.
    heights = np.concatenate([middles @ (eye - (x, 0, 0)) / np.linalg.norm(eye - (x, 0, 0)) for x in offsets])
    assert len(heights) >= MIN_LISTED_EDGES
    assert len(heights) > BLOCK_EDGES * edge_lists.FANOUT**2
    for each in (shown, unknown):
        assert (np.diff(each) > 0).all()
    assert not np.intersect1d(shown, unknown).size
    is_listed, is_shown = np.zeros((2, len(heights)), np.bool_)
    is_listed[shown] = is_listed[unknown] = is_shown[shown] = True
    assert is_listed[heights > 0.1].all()
    assert is_shown[heights > 0.3].all()
    assert not is_listed[heights < -0.2].any()


def test_the_edges_towards_the_eye_are_stepped_along() -> None:
    mesh = samples.icosphere(5)
    stack = np.stack([gx.translate(-1.5, 0.0, 0.0), gx.translate(1.5, 0.0, 0.0)])
    heights = np.tile(mesh.positions[mesh.edges].mean(axis=1)[:, 2], 2)
    camera = Camera.look_at((0.0, 0.0, 50.0), (0.0, 0.0, 0.0), fov_y=6.0)
    style = FRAME | {"size": (512, 512), "rasterizer": "compute"}
    with GpuDevice() as device:
        gx.render_array(mesh, device=device, camera=camera, transform=stack, **style)
        numbers = debug.read_buffer(device, "raster: seen edges", np.uint32).astype(np.int64)
    head = seen_edges.HEAD_BYTES // 4
    listed = numbers[head : head + numbers[head - 1]]
    assert len(np.unique(listed)) == len(listed)
    is_listed = np.zeros(len(heights), np.bool_)
    is_listed[listed] = True
    assert is_listed[heights > 0.1].all()
    assert not is_listed[heights < -0.5].any()


def test_edges_beside_the_picture_are_not_listed() -> None:
    camera = Camera.window((0.2, 0.4), (0.2, 0.35))
    with GpuDevice() as device:
        gx.render_array(samples.icosphere(6), device=device, camera=camera, **FRAME)
        lists = read_lists(device)
    assert 0 < sum(map(len, lists)) < 0.02 * len(samples.icosphere(6).edges)


def test_edges_beside_a_tile_are_not_listed_for_it(device_with_limits: Any) -> None:
    device = device_with_limits(max_texture_side=64)
    gx.render_array(samples.icosphere(6), device=device, **FRAME)
    n_edges = len(samples.icosphere(6).edges)
    shown, unknown = read_lists(device)  # of the tile in the lower right corner
    assert len(shown) + len(unknown) < 0.02 * n_edges


def test_a_list_beyond_a_binding_is_done_without(monkeypatch: pytest.MonkeyPatch, device_with_limits: Any) -> None:
    monkeypatch.setattr(edge_lists, "MIN_LISTED_EDGES", 1)
    mesh, stack = samples.icosphere(3), np.stack([gx.translate(0.01 * k, 0.0, 0.0) for k in range(20)])
    expected = gx.render_array(mesh, transform=stack, **FRAME)
    small = device_with_limits(max_binding_bytes=1 << 16)
    assert gx.render_array(mesh, device=small, transform=stack, **FRAME).tobytes() == expected.tobytes()
