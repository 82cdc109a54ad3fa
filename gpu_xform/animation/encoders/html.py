"""HTML page with a player for the frames: one file, which needs no network."""

import json
from base64 import b64encode
from html import escape
from importlib.resources import files
from typing import BinaryIO

from .frames import FrameSequence
from .image_codecs import Codec, encode_webp, lossy_codecs
from .parallel import encode_parallel

MAX_SIDE_PX = 16383  # of a WebP
CONTROLS_HEIGHT_PX, MIN_WIDTH_PX = 52, 480  # as in player.html
MAX_CELL_BYTES = 1_000_000  # of what a notebook shows for one animation
PAGE_BYTES = 14_000  # of the page without frames, escaped
BASE64_GROWTH = 4 / 3
N_SAMPLES = 3
LOSSLESS = Codec("webp", encode_webp)
TITLE, FACTS, FRAMES = "/* title */", "/* facts */", "/* frames */"
DEFAULT_TITLE = "Animation"


def write(file: BinaryIO, sequence: FrameSequence, *, max_bytes: int | None = None) -> None:
    """Write a page with a player for the frames, lossless ones, or lossy ones if these take more than `max_bytes`."""
    sequence.require_size_within(MAX_SIDE_PX, "a page")
    codec = LOSSLESS if max_bytes is None else _choose_codec(sequence, max_bytes)
    page = files(__package__).joinpath("player.html").read_text("utf-8")
    page = page.replace(TITLE, escape(sequence.title) or DEFAULT_TITLE)
    before, between, after = page.replace(FACTS, FRAMES).split(FRAMES)
    width, height = sequence.size
    facts = {
        "width": width,
        "height": height,
        "nFrames": sequence.n_frames,
        "fps": sequence.fps,
        "format": codec.format,
    }
    file.write((before + json.dumps(facts) + between).encode())
    with encode_parallel(sequence.frames, lambda pixels: b64encode(codec.encode(pixels))) as texts:
        for k, text in enumerate(texts):
            file.write((b",\n" if k else b"") + b'"' + text + b'"')
    file.write(after.encode())


def _choose_codec(sequence: FrameSequence, max_bytes: int) -> Codec:
    """Return the best codec with which the page takes `max_bytes`, by a few frames; else that of the smallest page."""
    step = max(1, sequence.n_frames // N_SAMPLES)
    samples = list(sequence.sample(range(0, sequence.n_frames, step)))
    room = (max_bytes - PAGE_BYTES) / BASE64_GROWTH / sequence.n_frames
    for codec in (LOSSLESS, *(codecs := lossy_codecs(sequence.is_opaque))):
        if max(len(codec.encode(pixels)) for pixels in samples) <= room:
            return codec
    return codecs[-1]


def embed_page(page: str, size: tuple[int, int]) -> str:
    """Return an element that isolates `page` from its surroundings, as a notebook shows it, for pictures of `size`."""
    width, height = max(size[0], MIN_WIDTH_PX), size[1] + CONTROLS_HEIGHT_PX
    style = f"width: 100%; max-width: {width}px; aspect-ratio: {width} / {height}; border: 0"
    return f'<iframe title="animation" style="{style}" srcdoc="{escape(page)}"></iframe>'
