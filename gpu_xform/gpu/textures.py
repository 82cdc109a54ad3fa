"""Textures: what render passes draw into, and shaders read texel by texel."""

import itertools
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.forks import is_fork
from .._core.interrupts import defer_interrupts
from ..errors import DeviceError
from .binding import wgpu
from .context import GpuContext
from .deletion_queue import flush, own

Usage = wgpu.TextureUsage
RENDER_TARGET: int = Usage.RENDER_ATTACHMENT | Usage.TEXTURE_BINDING | Usage.COPY_SRC | Usage.COPY_DST
STORAGE: int = Usage.STORAGE_BINDING | Usage.COPY_SRC | Usage.COPY_DST
ROW_ALIGNMENT_BYTES = 256  # of rows in a buffer that a texture is copied to or from

_ids = itertools.count()  # no two textures of a process have the same


class Texture:
    """`extent` = (width, height) texels of a `format` of WebGPU, kept and used again until it is released.

    usage : what is done with it, beside being copied
    label : what wgpu's messages call it
    """

    persistent = True

    def __init__(
        self,
        context: GpuContext,
        extent: tuple[int, int],
        format: str,  # noqa: A002
        usage: int = RENDER_TARGET,
        *,
        label: str,
    ) -> None:
        context.require_usable()
        self.context = context
        self.extent = extent
        self.format = format
        self.label = label
        self.id = next(_ids)
        width, height = extent
        with defer_interrupts(), context.translate_errors(f"allocate {width} x {height} texels", label):
            flush()
            self.handle: wgpu.GPUTexture = context.handle.create_texture(
                label=label, size=(width, height, 1), format=format, usage=usage
            )
            self.view: wgpu.GPUTextureView = self.handle.create_view(label=label)
            own(self, self.handle, self.view)
        self._released = False

    def upload(self, texels: npt.NDArray[Any]) -> None:
        """Fill the first texels, row by row, with what `texels` (n, ...) holds of each."""
        width = self.extent[0]
        n_rows, n_left = divmod(len(texels), width)
        texel_bytes = texels.nbytes // max(len(texels), 1)
        with (
            defer_interrupts(),
            self.context.lock,
            self.context.translate_errors(f"upload {texels.nbytes:,} bytes", self.label),
        ):
            self.require_submittable(self.context)
            parts = (texels[: n_rows * width], (width, n_rows), 0), (texels[n_rows * width :], (n_left, 1), n_rows)
            for part, (columns, rows), first_row in parts:
                if part.size:
                    self.context.handle.queue.write_texture(
                        {"texture": self.handle, "origin": (0, first_row, 0)},
                        np.ascontiguousarray(part),
                        {"bytes_per_row": columns * texel_bytes, "rows_per_image": rows},
                        (columns, rows, 1),
                    )

    def require_submittable(self, context: GpuContext) -> None:
        """Raise `DeviceError` if a submission on `context` that uses this texture would abort the process."""
        context.require_usable()
        if self.context is not context:
            raise DeviceError(f"the texture {self.label!r} of {self.context!r} cannot be used on {context!r}")
        if self._released:
            raise DeviceError(f"the texture {self.label!r} has been released")

    def release(self) -> None:
        """Give the memory back; releasing twice does nothing."""
        if not self._released:
            self._released = True
            if not is_fork():
                self.handle.destroy()


class TexturePool:
    """Textures by owner and key, kept from one call to the next as `BufferPool` keeps buffers."""

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._kept: dict[tuple[str, str], Texture] = {}

    def scratch(self, owner: str, key: str, extent: tuple[int, int], format: str) -> Texture:  # noqa: A002
        """Return the kept texture, made anew if it is narrower or lower than `extent`, or of another format.

        What it holds is undefined. The caller holds the device's lock until it is done with the texture.
        """
        slot = owner, key
        kept = self._kept.pop(slot, None)
        (width, height), (kept_width, kept_height) = extent, kept.extent if kept else (0, 0)
        if kept is None or kept.format != format or kept_width < width or kept_height < height:
            if kept is not None:
                kept.release()
            grown = max(width, kept_width), max(height, kept_height)
            kept = Texture(self._context, grown, format, label=f"{owner}: {key}")
        self._kept[slot] = kept
        return kept

    def clear(self) -> None:
        """Free every kept texture."""
        for texture in self._kept.values():
            texture.release()
        self._kept.clear()


def align_row(n_bytes: int) -> int:
    """Return how many bytes a row takes in a buffer that a texture is copied to or from."""
    return -(-n_bytes // ROW_ALIGNMENT_BYTES) * ROW_ALIGNMENT_BYTES
