"""MP4 (H.264) and WebM (VP9), by FFmpeg through PyAV: small, lossy, opaque, and played by every browser."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count
from types import ModuleType
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from ...errors import ArgumentError, MissingExtraError, SizeWarning
from ...imaging.image import Pixels
from .frames import Clip
from .parallel import encoded

if TYPE_CHECKING:
    from av.packet import Packet

MOST_OF_A_RATE = 65535
BT_709, LIMITED_RANGE = 1, 1  # as FFmpeg and the standard number them


@dataclass(frozen=True)
class VideoFormat:
    """A container, and what encodes into it, by FFmpeg's names."""

    name: str
    container: str
    encoder: str
    options: Mapping[str, str]
    container_options: Mapping[str, str] = field(default_factory=dict)
    side_multiple: int = 1
    largest_side: int = 65535


MP4 = VideoFormat(
    name="MP4",
    container="mp4",
    encoder="libx264",
    options={"preset": "veryfast", "crf": "18"},  # slower ones take up to four times as long for the same size here
    container_options={"movflags": "faststart"},
    side_multiple=2,  # a colour is stored for four pixels
    largest_side=16384,
)
WEBM = VideoFormat(
    name="WebM",
    container="webm",
    encoder="libvpx-vp9",
    options={"deadline": "realtime", "cpu-used": "6", "row-mt": "1", "crf": "24", "b": "0"},
)


def write_mp4(file: BinaryIO, clip: Clip) -> None:
    """Write an MP4 whose index comes first, so that it plays while it loads; odd sides gain a pixel."""
    _write(file, clip, MP4)


def write_webm(file: BinaryIO, clip: Clip) -> None:
    """Write a WebM."""
    _write(file, clip, WEBM)


def require_av() -> ModuleType:
    """Return PyAV, or raise `MissingExtraError`."""
    try:
        import av
    except ImportError:
        raise MissingExtraError("MP4 and WebM need PyAV: pip install 'gpu_xform[video]'") from None
    return av


def _write(file: BinaryIO, clip: Clip, form: VideoFormat) -> None:
    av = require_av()
    clip.require_size_within(form.largest_side, form.name)
    padding = [-side % form.side_multiple for side in clip.size]
    width, height = (side + extra for side, extra in zip(clip.size, padding, strict=True))
    if any(padding):
        warnings.warn(
            f"{form.name} holds even sizes only: {clip.size[0]} x {clip.size[1]} is padded to {width} x {height}",
            SizeWarning,
            stacklevel=2,
        )
    rate = Fraction(clip.fps).limit_denominator(MOST_OF_A_RATE)
    number = count()

    def compressed(pixels: Pixels) -> list["Packet[Any]"]:
        if pixels[..., 3].min() < 255:
            raise ArgumentError.expecting(
                "background", f"be opaque in {form.name}", reason="GIF, APNG, WebP and HTML can hold another"
            )
        padded = np.pad(pixels, ((0, padding[1]), (0, padding[0]), (0, 0)), mode="edge") if any(padding) else pixels
        frame = av.VideoFrame.from_ndarray(padded, format="rgba").reformat(format="yuv420p", dst_colorspace="itu709")
        frame.pts, frame.time_base = next(number), 1 / rate
        packets: list[Packet[Any]] = stream.encode(frame)
        return packets

    try:
        # By its name, because moving the index forward takes opening the file a second time.
        with av.open(file.name, "w", format=form.container, options=dict(form.container_options)) as container:
            stream = container.add_stream(form.encoder, rate=rate, options=dict(form.options))
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            context = stream.codec_context
            context.colorspace = context.color_primaries = context.color_trc = BT_709
            context.color_range = LIMITED_RANGE
            container.start_encoding()
            with encoded(clip.frames, compressed, n_workers=1) as packets:
                for each in packets:
                    container.mux(each)
            container.mux(stream.encode(None))
    except av.error.FFmpegError as error:
        if isinstance(error, OSError):
            raise
        what = f"{width} x {height} at {clip.fps:g} frames a second"
        raise ArgumentError(f"{form.name}: {form.encoder} cannot encode {what}: {error}") from error
