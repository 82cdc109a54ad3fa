"""The texture that a picture is drawn on, and its way back to the host."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import wgpu

from .buffers import READBACK, Buffer
from .faults import device_errors

if TYPE_CHECKING:
    from .device import Device

FORMAT = "rgba8unorm"  # not -srgb: colours mix as the bytes of the file do, like other plotting programs' lines
ROW_ALIGNMENT = 256


class Target:
    """A texture of `size` = (width, height) pixels, and the buffer that its rows are read back through."""

    def __init__(self, device: "Device", size: tuple[int, int]) -> None:
        width, height = size
        self.size = size
        self.row_bytes = -(-4 * width // ROW_ALIGNMENT) * ROW_ALIGNMENT
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC
        with device_errors(f"allocate a picture of {width} x {height} pixels"):
            self.texture = device.handle.create_texture(size=(width, height, 1), format=FORMAT, usage=usage)
            self.rows = Buffer(device, self.row_bytes * height, READBACK)

    def attachment(self, background: tuple[float, float, float, float]) -> dict[str, object]:
        """Return the color attachment that begins with `background`, premultiplied."""
        red, green, blue, alpha = background
        return {
            "view": self.texture.create_view(),
            "load_op": "clear",
            "store_op": "store",
            "clear_value": (red * alpha, green * alpha, blue * alpha, alpha),
        }

    def copy_rows(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record the copy of the finished picture into the read-back buffer."""
        width, height = self.size
        encoder.copy_texture_to_buffer(
            {"texture": self.texture},
            {"buffer": self.rows.handle, "bytes_per_row": self.row_bytes, "rows_per_image": height},
            (width, height, 1),
        )

    def pixels(self) -> npt.NDArray[np.uint8]:
        """Return the picture, premultiplied: (height, width, 4)."""
        width, height = self.size
        with self.rows.downloaded(self.row_bytes * height) as view:
            return view.reshape(height, self.row_bytes)[:, : 4 * width].reshape(height, width, 4).copy()

    def release(self) -> None:
        """Give the memory back."""
        self.texture.destroy()
        self.rows.release()
