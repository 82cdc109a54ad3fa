"""Textures, and the pool that keeps them from one call to the next."""

from collections.abc import Iterator

import numpy as np
import pytest

from gpu_xform.errors import DeviceError
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.textures import STORAGE, Texture, TexturePool, align_row

FORMAT = "rgba8unorm"


@pytest.fixture
def pool(device: GpuDevice) -> Iterator[TexturePool]:
    """An empty pool."""
    own = TexturePool(device.context)
    yield own
    own.clear()


@pytest.mark.parametrize("smaller", [(20, 10), (19, 10), (20, 9), (1, 1)])
def test_a_texture_that_is_large_enough_is_found_again(smaller: tuple[int, int], pool: TexturePool) -> None:
    first = pool.scratch("test", "picture", (20, 10), FORMAT)
    assert first.extent == (20, 10)
    assert pool.scratch("test", "picture", smaller, FORMAT) is first


@pytest.mark.parametrize(
    ("larger", "grown"), [((21, 10), (21, 10)), ((5, 11), (20, 11)), ((30, 4), (30, 10)), ((64, 48), (64, 48))]
)
def test_a_texture_grows_each_way(larger: tuple[int, int], grown: tuple[int, int], pool: TexturePool) -> None:
    first = pool.scratch("test", "picture", (20, 10), FORMAT)
    second = pool.scratch("test", "picture", larger, FORMAT)
    assert second.extent == grown
    assert second.id != first.id
    with pytest.raises(DeviceError, match=r"^the texture 'test: picture' has been released$"):
        first.require_submittable(first.context)
    assert pool.scratch("test", "picture", (20, 10), FORMAT) is second


def test_textures_of_other_owners_keys_and_formats_are_others(pool: TexturePool) -> None:
    slots = [("test", "picture"), ("test", "other"), ("raster", "picture")]
    textures = [pool.scratch(*slot, (4, 4), FORMAT) for slot in slots]
    assert len({texture.id for texture in textures}) == 3
    assert [texture.label for texture in textures] == ["test: picture", "test: other", "raster: picture"]
    assert [pool.scratch(*slot, (4, 4), FORMAT) for slot in slots] == textures
    other = pool.scratch("test", "picture", (4, 4), "r32float")
    assert other.format == "r32float"
    assert other is not textures[0]


def test_clearing_frees_all(pool: TexturePool) -> None:
    texture = pool.scratch("test", "picture", (4, 4), FORMAT)
    pool.clear()
    with pytest.raises(DeviceError, match="released"):
        texture.require_submittable(texture.context)
    assert pool.scratch("test", "picture", (4, 4), FORMAT) is not texture
    texture.release()
    texture.release()


def test_a_texture_of_another_or_a_closed_device_cannot_be_used(device: GpuDevice, single_device: GpuDevice) -> None:
    texture = Texture(single_device.context, (4, 4), FORMAT, label="foreign")
    texture.require_submittable(single_device.context)
    with pytest.raises(DeviceError, match=r"^the texture 'foreign' of Device\(.*\) cannot be used on Device\("):
        texture.require_submittable(device.context)
    texture.release()
    with GpuDevice() as other:
        own = Texture(other.context, (4, 4), FORMAT, label="own")
    with pytest.raises(DeviceError, match="closed"):
        own.require_submittable(other.context)
    with pytest.raises(DeviceError, match="closed"):
        Texture(other.context, (4, 4), FORMAT, label="late")


def test_a_texture_beyond_the_limits_is_an_error_that_names_it(device: GpuDevice) -> None:
    side = device.limits.max_texture_side
    with pytest.raises(DeviceError, match=rf"^the device could not allocate {4 * side + 1} x 1 texels \('huge'\): "):
        Texture(device.context, (4 * side + 1, 1), FORMAT, label="huge")


def test_rows_begin_at_multiples_of_256_bytes() -> None:
    assert [align_row(n) for n in (1, 255, 256, 257, 4 * 90)] == [256, 256, 256, 512, 512]


@pytest.mark.parametrize("n_texels", [1, 64, 65, 128, 150])
def test_texels_are_uploaded_row_by_row(device: GpuDevice, n_texels: int) -> None:
    texels = np.arange(4 * n_texels, dtype=np.float32).reshape(-1, 4)
    texture = Texture(device.context, (64, 3), "rgba32float", STORAGE, label="table")
    buffer = Buffer(device.context, 3 * 64 * 16, label="copy")
    texture.upload(texels)
    with device.encode_commands(texture, buffer, label="copy") as encoder:
        encoder.copy_texture_to_buffer(texture, buffer, texture.extent, 64 * 16)
    with buffer.map_read(texels.nbytes) as view:
        np.testing.assert_array_equal(view.view(np.float32).reshape(-1, 4), texels)
    buffer.release()
    texture.release()
