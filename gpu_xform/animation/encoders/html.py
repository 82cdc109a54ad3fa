"""HTML page with a player for the frames: one file, which needs no network."""

import json
from base64 import b64encode
from html import escape
from importlib.resources import files
from typing import BinaryIO

from .frames import FrameSequence
from .image_codecs import encode_webp
from .parallel import encode_parallel

MAX_SIDE_PX = 16383  # of a WebP
CONTROLS_HEIGHT_PX, MIN_WIDTH_PX = 52, 480  # as in player.html
TITLE, FACTS, FRAMES = "/* title */", "/* facts */", "/* frames */"
DEFAULT_TITLE = "Animation"


def write(file: BinaryIO, sequence: FrameSequence) -> None:
    """Write a page with every frame as a lossless WebP, and a player for them."""
    sequence.require_size_within(MAX_SIDE_PX, "a page")
    page = files(__package__).joinpath("player.html").read_text("utf-8")
    page = page.replace(TITLE, escape(sequence.title) or DEFAULT_TITLE)
    before, between, after = page.replace(FACTS, FRAMES).split(FRAMES)
    width, height = sequence.size
    facts = {"width": width, "height": height, "nFrames": sequence.n_frames, "fps": sequence.fps}
    file.write((before + json.dumps(facts) + between).encode())
    with encode_parallel(sequence.frames, lambda pixels: b64encode(encode_webp(pixels))) as texts:
        for k, text in enumerate(texts):
            file.write((b",\n" if k else b"") + b'"' + text + b'"')
    file.write(after.encode())


def embed_page(page: str, size: tuple[int, int]) -> str:
    """Return an element that isolates `page` from its surroundings, as a notebook shows it, for pictures of `size`."""
    width, height = max(size[0], MIN_WIDTH_PX), size[1] + CONTROLS_HEIGHT_PX
    style = f"width: 100%; max-width: {width}px; aspect-ratio: {width} / {height}; border: 0"
    return f'<iframe title="animation" style="{style}" srcdoc="{escape(page)}"></iframe>'
