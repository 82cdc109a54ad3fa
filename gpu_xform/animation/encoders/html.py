"""A page that plays the frames: one file, which needs no network."""

import json
from base64 import b64encode
from html import escape
from importlib.resources import files
from typing import BinaryIO

from .frames import Clip
from .image_codecs import webp
from .parallel import encoded

LARGEST_SIDE = 16383  # of a WebP
CONTROLS_HEIGHT, NARROWEST = 52, 480  # pixels, as in player.html
FACTS, FRAMES = "/* facts */", "/* frames */"


def write(file: BinaryIO, clip: Clip) -> None:
    """Write a page with every frame as a lossless WebP, and a player for them."""
    clip.require_size_within(LARGEST_SIDE, "a page")
    page = files(__package__).joinpath("player.html").read_text("utf-8")
    before, between, after = page.replace(FACTS, FRAMES).split(FRAMES)
    width, height = clip.size
    facts = {"width": width, "height": height, "nFrames": clip.n_frames, "fps": clip.fps}
    file.write((before + json.dumps(facts) + between).encode())
    with encoded(clip.frames, lambda pixels: b64encode(webp(pixels))) as texts:
        for k, text in enumerate(texts):
            file.write((b",\n" if k else b"") + b'"' + text + b'"')
    file.write(after.encode())


def embedded(page: str, size: tuple[int, int]) -> str:
    """Return an element that holds `page` apart from all around it, as a notebook shows it, for pictures of `size`."""
    width, height = max(size[0], NARROWEST), size[1] + CONTROLS_HEIGHT
    style = f"width: 100%; max-width: {width}px; aspect-ratio: {width} / {height}; border: 0"
    return f'<iframe title="animation" style="{style}" srcdoc="{escape(page)}"></iframe>'
