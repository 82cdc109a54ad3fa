"""The state of points on a graphics adapter: a texture with two texels per point, and another that the next step fills.

Textures, as lavapipe reads texels in a third of the time that it takes for elements of a buffer.
"""

import numpy as np
import numpy.typing as npt

from ..gpu.device import GpuDevice
from ..gpu.textures import STORAGE, Texture

POOL_OWNER = "simulation"
TEXELS_PER_ROW = 2048
TEXELS_PER_POINT = 2
TEXEL_BYTES = 16


class PointState:
    """Positions, with one over the mass, and velocities, with the steps of the frame: a texel each."""

    def __init__(self, device: GpuDevice, n_points: int) -> None:
        self._device = device
        self._n_points = n_points
        self.textures = [create_table(device, TEXELS_PER_POINT * n_points, "rgba32float", "points") for _ in range(2)]
        self._present = 0

    @property
    def present(self) -> Texture:
        """The texture that holds the present state."""
        return self.textures[self._present]

    def bindings(self, turn: int) -> dict[str, Texture]:
        """Return what a step binds, what it reads and what it fills, after `turn` steps from now."""
        source = (self._present + turn) % 2
        return {"state": self.textures[source], "next_state": self.textures[source ^ 1]}

    def swap(self, n_steps: int = 1) -> None:
        """Take what the last of so many steps has filled as the present state."""
        self._present ^= n_steps % 2

    def write(self, positions: npt.NDArray[np.float32], velocities: npt.NDArray[np.float32]) -> None:
        """Set the present state: (n, 4) each."""
        texels = np.stack([positions, velocities], axis=1).astype(np.float32, copy=False)
        self.present.upload(texels.reshape(-1, 4))

    def read(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return the present positions and velocities: (n, 4) each."""
        row_bytes = TEXEL_BYTES * TEXELS_PER_ROW
        with self._device.lock:
            texture = self.present
            buffer = self._device.pool.scratch(POOL_OWNER, "points", row_bytes * texture.extent[1])
            with self._device.encode_commands(buffer, texture, label="springs: read") as encoder:
                encoder.copy_texture_to_buffer(texture, buffer, texture.extent, row_bytes)
            with buffer.map_read(TEXELS_PER_POINT * TEXEL_BYTES * self._n_points) as view:
                state = view.view(np.float32).reshape(-1, 2, 4)
                return state[:, 0].copy(), state[:, 1].copy()


def create_table(device: GpuDevice, n_texels: int, format: str, name: str) -> Texture:  # noqa: A002
    """Return a texture of at least `n_texels`, row by row, as `texel` in wgsl/shared/texel.wgsl finds them."""
    extent = TEXELS_PER_ROW, max(1, -(-n_texels // TEXELS_PER_ROW))
    return Texture(device.context, extent, format, STORAGE, label=f"springs: {name}")
