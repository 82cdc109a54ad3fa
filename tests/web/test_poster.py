"""Posters are small in bytes whatever they show, and as large as that allows."""

import base64
import io
from typing import Any

import numpy as np
import pytest
from PIL import Image, features

import gpu_xform as gx
from gpu_xform.web.poster import MAX_BYTES, SIDES_PX, encode_poster

BALL = gx.samples.icosphere(3)


def open_poster(url: str) -> tuple[int, Image.Image]:
    """Return the bytes of a poster's file, and its picture."""
    data = base64.b64decode(url.split(";base64,")[1])
    return len(data), Image.open(io.BytesIO(data))


@pytest.mark.parametrize("has_webp", [True, False])
@pytest.mark.parametrize("options", [{}, {"background": None}, {"fill": "face", "edges": None}])
def test_a_poster_is_small_and_shows_the_picture(
    options: dict[str, Any], has_webp: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(features, "check", lambda _: has_webp)
    picture = gx.render_array(BALL, size=(320, 240), **options)
    n_bytes, poster = open_poster(encode_poster(picture))
    assert n_bytes <= MAX_BYTES
    assert poster.size[0] in SIDES_PX
    small = Image.fromarray(picture).resize(poster.size, Image.Resampling.LANCZOS)
    shown, expected = (np.asarray(image.convert("RGBA"), np.float64) for image in (poster, small))
    opaque = [image[..., :3] * image[..., 3:] / 255 for image in (shown, expected)]
    assert np.abs(opaque[0] - opaque[1]).mean() < 20


def test_a_plain_picture_has_a_large_poster_and_a_small_one_its_own_size() -> None:
    plain = np.full((600, 800, 4), 255, np.uint8)
    assert open_poster(encode_poster(plain))[1].size == (800, 600)
    assert open_poster(encode_poster(plain[:32, :48]))[1].size == (48, 32)
