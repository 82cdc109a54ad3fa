"""Pictures compared: small ones by hand, any by an oracle in float64, and drawn ones by what has changed in them."""

import struct
import zlib
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

import gpu_xform as gx
from gpu_xform.errors import ArgumentError
from gpu_xform.imaging.image import Pixels, premultiply

WHITE, BLACK = (255, 255, 255, 255), (0, 0, 0, 255)


def pixels(*rows: list[tuple[int, ...]]) -> Pixels:
    return np.array(rows, np.uint8)


PICTURE = pixels([WHITE, BLACK, WHITE], [WHITE, (250, 255, 255, 255), (0, 0, 255, 255)])
REFERENCE = pixels([WHITE, BLACK, (255, 247, 255, 255)], [WHITE, WHITE, (0, 0, 246, 255)])
# By hand: 8 in the green of (2, 0), 5 in the red of (1, 1), 9 in the blue of (2, 1).


def test_a_difference_by_hand() -> None:
    found = gx.compare_images(PICTURE, REFERENCE)
    assert found.by_pixel.tolist() == [[0, 0, 8], [0, 5, 9]]
    assert (found.largest, found.largest_at, found.mean) == (9, (2, 1), 22 / 24)
    assert [gx.compare_images(PICTURE, REFERENCE, threshold=t).n_pixels for t in (0, 4.9, 5, 8, 9)] == [3, 3, 2, 1, 0]
    assert (found.threshold, found.n_pixels) == (8, 1)


def test_a_difference_tells_how_large_it_is_and_where() -> None:
    found = gx.compare_images(PICTURE, REFERENCE)
    assert repr(found) == "<Difference: 1 of 3 x 2 pixels by more than 8, largest 9 at (2, 1), mean 0.917>"
    none = gx.compare_images(PICTURE, PICTURE, threshold=0.5)
    assert repr(none) == "<Difference: 0 of 3 x 2 pixels by more than 0.5, largest 0, mean 0>"


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("as_", [Image.fromarray, lambda array: array[..., :3], "path", Path])
def test_pictures_may_be_images_arrays_and_files(as_: Any, swap: bool, tmp_path: Path) -> None:
    given_as = as_
    if as_ == "path" or as_ is Path:
        Image.fromarray(REFERENCE).save(tmp_path / "reference.png")
        given_as = lambda _: str(tmp_path / "reference.png") if as_ == "path" else tmp_path / "reference.png"  # noqa: E731
    both = [PICTURE, given_as(REFERENCE)]
    assert gx.compare_images(*(both[::-1] if swap else both)).by_pixel.tolist() == [[0, 0, 8], [0, 5, 9]]


def test_a_picture_is_compared_with_the_file_it_was_saved_to(tmp_path: Path) -> None:
    picture = gx.render(gx.samples.house(), size=(90, 60), background=None)
    for mode in ("RGBA", "P"):
        picture.convert(mode).save(tmp_path / "house.png")
        assert (gx.compare_images(picture, tmp_path / "house.png", threshold=0).n_pixels == 0) == (mode == "RGBA")
    grey = gx.render(gx.samples.house(), size=(90, 60))
    grey.convert("L").save(tmp_path / "grey.png")
    assert gx.compare_images(grey, tmp_path / "grey.png").largest == 0


def test_colours_count_by_their_alpha() -> None:
    clear, hidden = pixels([(0, 0, 0, 0)]), pixels([(200, 100, 50, 0)])
    assert gx.compare_images(clear, hidden).largest == 0
    half, other = pixels([(200, 100, 50, 128)]), pixels([(0, 100, 50, 128)])
    assert gx.compare_images(half, other).by_channel.tolist() == [[[100, 0, 0, 0]]]
    assert gx.compare_images(pixels([(0, 0, 0, 3)]), pixels([(0, 0, 0, 250)])).largest == 247


@given(hnp.arrays(np.uint8, (2, 3, 2, 4)))
def test_colours_are_multiplied_exactly_and_differences_are_theirs(pair: Pixels) -> None:
    exact = [
        [round(Fraction(int(pixel[c]) * int(pixel[3]), 255)) if c < 3 else int(pixel[3]) for c in range(4)]
        for pixel in pair.reshape(-1, 4)
    ]
    expected = np.reshape(exact, pair.shape)
    assert (premultiply(pair) == expected).all()
    found = gx.compare_images(*pair)
    apart = np.abs(expected[0] - expected[1])
    assert (found.by_channel == apart).all()
    assert found.mean == apart.mean()
    assert found.largest == apart.max() == apart[found.largest_at[1], found.largest_at[0]].max()


@given(hnp.arrays(np.uint8, (2, 2, 3, 4)), st.integers(0, 255))
def test_pixels_that_count_as_equal_look_equal_on_any_background(pair: Pixels, background: int) -> None:
    alpha = pair[..., 3:] / 255
    seen = pair[..., :3] * alpha + background * (1 - alpha)
    apart = np.abs(seen[0] - seen[1]).max(axis=2)
    # On a background, the alpha's difference adds to the colour's; each colour is rounded once.
    assert (apart <= 2.0 * gx.compare_images(*pair).by_pixel + 1).all()


@pytest.mark.slow
def test_any_missing_edge_is_found_where_a_slight_shift_is_not() -> None:
    house = gx.samples.house()
    camera = gx.Camera.fit(house)
    whole = gx.render_array(house, camera=camera)
    for missing in range(len(house.edges)):
        lacking = gx.render_array(house, camera=camera, edges=np.delete(house.edges, missing, axis=0))
        found = gx.compare_images(lacking, whole)
        assert found.n_pixels > 500
        assert found.largest == 255
        assert found.mean < 0.2
    width = gx.samples.house().bounds[1, 0] - gx.samples.house().bounds[0, 0]
    hundredth = gx.render_array(house, camera=camera, transform=gx.translate(width / 1024 / 100, 0, 0))
    assert 0 < gx.compare_images(hundredth, whole).largest <= 8


def test_the_picture_of_a_difference() -> None:
    picture = pixels([WHITE, BLACK, BLACK, (0, 255, 0, 255), (0, 0, 0, 0), (251, 251, 251, 255), BLACK])
    reference = pixels([BLACK, BLACK, WHITE, (255, 0, 0, 255), (0, 0, 0, 255), WHITE, (0, 0, 0, 0)])
    shown = np.asarray(gx.compare_images(picture, reference).image()).tolist()[0]
    blue, red = [0, 80, 255, 255], [208, 0, 0, 255]
    assert shown == [blue, [191, 191, 191, 255], red, blue, blue, [254, 254, 254, 255], red]


@pytest.mark.parametrize(
    ("picture", "reference", "threshold", "message"),
    [
        (PICTURE, PICTURE[:, :2], 8, r"reference must have the size of the picture, 3 x 2, got 2 x 2"),
        (PICTURE, PICTURE.swapaxes(0, 1), 8, r"3 x 2, got 2 x 3"),
        (PICTURE[..., 0], PICTURE, 8, r"picture must have shape \(height, width, 3\) or .*, got \(2, 3\)"),
        (PICTURE, PICTURE[..., :2], 8, r"reference must have shape .*, got \(2, 3, 2\)"),
        (PICTURE[:0], PICTURE[:0], 8, "picture must have pixels"),
        (PICTURE, PICTURE, -1, "threshold must be from 0 to 255, got -1"),
        (PICTURE, PICTURE, 256, "threshold"),
        (PICTURE, PICTURE, np.nan, "threshold must be finite"),
        (Image.new("I;16", (3, 2)), PICTURE, 8, "picture must have a mode of 1, L, .*, got I;16"),
        (PICTURE, Image.new("CMYK", (3, 2)), 8, "reference must have a mode of .*, got CMYK"),
    ],
)
def test_what_cannot_be_compared(picture: Any, reference: Any, threshold: Any, message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        gx.compare_images(picture, reference, threshold=threshold)


@pytest.mark.parametrize("value", [PICTURE.astype(float), None, 3, PICTURE.tolist()])
def test_what_is_no_picture(value: Any) -> None:
    with pytest.raises(
        gx.ArgumentTypeError, match="reference must be an image, an array of uint8 or a PNG file's path"
    ):
        gx.compare_images(PICTURE, value)


def test_files_that_are_no_pictures(tmp_path: Path) -> None:
    path = tmp_path / "house.png"
    with pytest.raises(FileNotFoundError, match=r"house\.png"):
        gx.compare_images(PICTURE, path)
    Image.fromarray(PICTURE).save(path)
    whole = path.read_bytes()
    for damaged in (b"", b"GIF89a", whole[:40], whole[:-30], whole.replace(b"IDAT", b"IDAX")):
        path.write_bytes(damaged)
        with pytest.raises(gx.ArgumentError, match=r"reference must be a PNG file, got '.*house\.png': "):
            gx.compare_images(PICTURE, path)
    Image.fromarray(np.full((2, 3), 40000, np.uint16)).save(path)
    with pytest.raises(gx.ArgumentError, match="I;16"):
        gx.compare_images(PICTURE, path)


def test_a_file_as_large_as_pictures_come_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 2)  # of which `render` knows nothing
    Image.fromarray(PICTURE).save(tmp_path / "large.png")
    assert gx.compare_images(PICTURE, tmp_path / "large.png").largest == 0


def test_the_arrays_are_left_as_they_were() -> None:
    translucent: npt.NDArray[np.uint8] = pixels([(200, 100, 50, 128)])
    gx.compare_images(translucent, translucent)
    assert translucent.tolist() == [[[200, 100, 50, 128]]]


def test_the_size_of_a_file_is_compared_before_it_is_decoded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file of a hundred bytes may declare a picture of gigabytes."""
    path = tmp_path / "huge.png"
    header = b"IHDR" + struct.pack(">II5B", 60_000, 60_000, 8, 6, 0, 0, 0)
    chunks = [
        struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) for chunk in (header, b"IDAT")
    ]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))

    def load(_: object) -> None:
        raise AssertionError("it is decoded")

    monkeypatch.setattr("PIL.PngImagePlugin.PngImageFile.load", load)
    with pytest.raises(ArgumentError, match="reference must have the size of the picture, 2 x 3, got 60000 x 60000"):
        gx.compare_images(np.zeros((3, 2, 4), np.uint8), path)
