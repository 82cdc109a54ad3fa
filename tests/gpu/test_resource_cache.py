"""What stays on a device between pictures, and what goes."""

import gc
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Mesh, samples
from gpu_xform.gpu import resource_cache
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice
from tests.support.spies import record_uploads

STYLE: dict[str, Any] = {"fill": "#ffe0a0", "point_size": 3.0, "size": (80, 60)}
CAMERA = Camera.look_at((3, 2, 5), (0, 0, 0))


@pytest.fixture
def own() -> Iterator[GpuDevice]:
    """A device on which nothing is cached yet."""
    with GpuDevice() as device:
        yield device


@pytest.fixture
def uploads(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The sizes of all arrays that are uploaded, in bytes."""
    return record_uploads(monkeypatch)


def kept(device: GpuDevice) -> dict[Any, Buffer]:
    return {key: entry.buffer for (_, key), entry in device.resource_cache._entries.items()}


@pytest.mark.parametrize("edges", [None, "feature", "silhouette", ["silhouette", "boundary"]])
def test_the_second_picture_uploads_nothing_of_the_mesh(edges: Any, own: GpuDevice, uploads: list[int]) -> None:
    mesh = samples.icosphere(4)
    first = gx.render_array(mesh, edges=edges, camera=CAMERA, device=own, feature_angle=1.0, **STYLE)
    smallest = 4 * mesh.n_points
    assert max(uploads) >= smallest
    uploads.clear()
    again = gx.render_array(mesh, edges=edges, camera=CAMERA, device=own, feature_angle=1.0, **STYLE)
    assert max(uploads) < 2048 < smallest
    assert again.tobytes() == first.tobytes()


def test_a_change_of_what_is_drawn_is_seen(own: GpuDevice) -> None:
    mesh = samples.cube()
    camera = Camera.fit(mesh)
    one, two = (
        gx.render_array(mesh, edges="feature", feature_angle=angle, camera=camera, device=own, size=(50, 50))
        for angle in (30.0, 89.0)
    )
    assert one.tobytes() == two.tobytes()
    bent = Mesh([(0, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0.5)], [(1, 0, 2), (0, 1, 3)])
    pictures = [
        gx.render_array(bent, edges="feature", feature_angle=angle, camera=CAMERA, device=own, size=(50, 50))
        for angle in (10.0, 60.0, 10.0)
    ]
    assert pictures[0].tobytes() == pictures[2].tobytes() != pictures[1].tobytes()


def test_what_belongs_to_a_mesh_goes_with_it_at_the_next_picture(own: GpuDevice) -> None:
    mesh, other = samples.icosphere(2), samples.cube()
    gx.render_array(mesh, device=own, **STYLE)
    gx.render_array(other, device=own, **STYLE)
    buffers = list(own.resource_cache._entries.values())
    of_mesh = [entry.buffer for entry in buffers if entry.owner() is mesh]
    assert len(of_mesh) >= 4
    assert not any(buffer._released for buffer in of_mesh)
    del mesh, buffers
    gc.collect()
    gx.render_array(other, device=own, **STYLE)
    assert all(buffer._released for buffer in of_mesh)
    assert {id(other)} == {owner for owner, _ in own.resource_cache._entries}


def test_many_meshes_that_come_and_go_leave_nothing(own: GpuDevice) -> None:
    for i in range(30):
        turned = samples.cube().transformed(gx.rotate_y(0.1 * i))
        shown = gx.render_array(turned, camera=CAMERA, device=own, size=(40, 30))
        assert (
            shown.tobytes()
            == gx.render_array(Mesh(turned.positions, turned.faces), camera=CAMERA, size=(40, 30)).tobytes()
        )
        del turned
    own.resource_cache.trim()
    assert not kept(own)


def test_beyond_the_budget_the_least_recently_used_goes_first(own: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    meshes = [samples.icosphere(2), samples.torus(20, 15), samples.snub_dodecahedron()]
    pictures = [gx.render_array(mesh, device=own, **STYLE).tobytes() for mesh in meshes]
    gx.render_array(meshes[0], device=own, **STYLE)
    held = {
        id(mesh): sum(r.buffer.n_bytes for (owner, _), r in own.resource_cache._entries.items() if owner == id(mesh))
        for mesh in meshes
    }
    monkeypatch.setattr(resource_cache, "MAX_CACHED_BYTES", held[id(meshes[0])] + held[id(meshes[2])])
    own.resource_cache.trim()
    assert {owner for owner, _ in own.resource_cache._entries} == {id(meshes[0]), id(meshes[2])}
    monkeypatch.setattr(resource_cache, "MAX_CACHED_BYTES", 0)
    for mesh, picture in zip(meshes, pictures, strict=True):
        assert gx.render_array(mesh, device=own, **STYLE).tobytes() == picture
    own.resource_cache.trim()
    assert not kept(own)


def test_an_array_is_made_once_per_owner_and_key(own: GpuDevice) -> None:
    owners = [samples.cube(), samples.cube()]
    made: list[int] = []

    def array() -> npt.NDArray[np.uint32]:
        made.append(len(made))
        return np.full(5, made[-1], np.uint32)

    buffers = [
        own.resource_cache.get(owner, key, array) for _ in range(2) for owner in owners for key in ("a", ("b", 1))
    ]
    assert made == [0, 1, 2, 3]
    assert buffers[:4] == buffers[4:]
    for i, buffer in enumerate(buffers[:4]):
        with buffer.map_read(20) as view:
            assert (view.view(np.uint32) == i).all()
    assert own.resource_cache.get(owners[0], "empty", lambda: np.empty((0, 2), np.uint32)).n_bytes == 4
