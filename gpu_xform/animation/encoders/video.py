"""Video files, MP4 (H.264) and WebM (VP9), by FFmpeg through PyAV: small, lossy, opaque, played by every browser."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count
from types import ModuleType
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from ..._core.interrupts import defer_interrupts
from ...errors import ArgumentError, MissingExtraError, SizeWarning
from ...imaging.image import Pixels
from .frames import FrameSequence
from .parallel import encode_parallel

if TYPE_CHECKING:
    from av.packet import Packet

MAX_RATE_DENOMINATOR = 65535
BT_709, LIMITED_RANGE = 1, 1  # as FFmpeg and the standard number them


@dataclass(frozen=True)
class VideoFormat:
    """A container and its encoder, by FFmpeg's names."""

    name: str
    container: str
    encoder: str
    options: Mapping[str, str]
    container_options: Mapping[str, str] = field(default_factory=dict)
    side_multiple: int = 1
    max_side_px: int = 65535


MP4 = VideoFormat(
    name="MP4",
    container="mp4",
    encoder="libx264",
    options={"preset": "veryfast", "crf": "18"},  # slower presets take up to four times as long for the same size here
    container_options={"movflags": "faststart"},
    side_multiple=2,  # one colour is stored per four pixels
    max_side_px=16384,
)
WEBM = VideoFormat(
    name="WebM",
    container="webm",
    encoder="libvpx-vp9",
    options={"deadline": "realtime", "cpu-used": "6", "row-mt": "1", "crf": "24", "b": "0"},
)


def write_mp4(file: BinaryIO, sequence: FrameSequence) -> None:
    """Write an MP4 whose index comes first, so that it plays while it loads; odd sides are padded by a pixel."""
    _write(file, sequence, MP4)


def write_webm(file: BinaryIO, sequence: FrameSequence) -> None:
    """Write a WebM."""
    _write(file, sequence, WEBM)


def require_av() -> ModuleType:
    """Return PyAV, or raise `MissingExtraError`."""
    try:
        with defer_interrupts():
            import av
    except ImportError:
        raise MissingExtraError("MP4 and WebM need PyAV: pip install 'gpu_xform[video]'") from None
    return av


def _write(file: BinaryIO, sequence: FrameSequence, spec: VideoFormat) -> None:
    av = require_av()
    sequence.require_size_within(spec.max_side_px, spec.name)
    padding = [-side % spec.side_multiple for side in sequence.size]
    width, height = (side + extra for side, extra in zip(sequence.size, padding, strict=True))
    if any(padding):
        warnings.warn(
            f"{spec.name} holds even sizes only: {' x '.join(map(str, sequence.size))} is padded to {width} x {height}",
            SizeWarning,
            stacklevel=2,
        )
    rate = Fraction(sequence.fps).limit_denominator(MAX_RATE_DENOMINATOR)
    frame_index = count()

    def encode(pixels: Pixels) -> list["Packet[Any]"]:
        if pixels[..., 3].min() < 255:
            raise ArgumentError.expecting(
                "background", f"be opaque in {spec.name}", reason="GIF, APNG, WebP and HTML can hold another"
            )
        padded = np.pad(pixels, ((0, padding[1]), (0, padding[0]), (0, 0)), mode="edge") if any(padding) else pixels
        frame = av.VideoFrame.from_ndarray(padded, format="rgba").reformat(format="yuv420p", dst_colorspace="itu709")
        frame.pts, frame.time_base = next(frame_index), 1 / rate
        packets: list[Packet[Any]] = stream.encode(frame)
        return packets

    try:
        # By its name, because FFmpeg opens the file a second time to move the index forward.
        with av.open(file.name, "w", format=spec.container, options=dict(spec.container_options)) as container:
            stream = container.add_stream(spec.encoder, rate=rate, options=dict(spec.options))
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            context = stream.codec_context
            context.colorspace = context.color_primaries = context.color_trc = BT_709
            context.color_range = LIMITED_RANGE
            container.start_encoding()
            with encode_parallel(sequence.frames, encode, n_workers=1) as packet_lists:
                for packets in packet_lists:
                    container.mux(packets)
            container.mux(stream.encode(None))
    except av.error.FFmpegError as error:
        if isinstance(error, OSError):
            raise
        what = f"{width} x {height} at {sequence.fps:g} frames per second"
        raise ArgumentError(f"{spec.name}: {spec.encoder} cannot encode {what}: {error}") from error
