"""Every format, read back: how many pictures, how long each is shown, and what is in them."""

import contextlib
import errno
import io
import os
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform.animation.encoders.frames import FrameSequence
from gpu_xform.animation.encoders.image_codecs import encode_png, encode_webp
from gpu_xform.animation.encoders.parallel import MAX_WORKERS, encode_parallel
from gpu_xform.animation.encoders.registry import ENCODERS, make_writer
from gpu_xform.errors import ArgumentError, MissingExtraError, SizeWarning
from gpu_xform.gpu.device import GpuDevice
from tests.support.browser import Browser
from tests.support.types import Pixels

EXACT = ("apng", "png", "webp")
VIDEO = ("mp4", "webm")
NAMES = [*(f"out.{kind}" for kind in ENCODERS), "out-{frame:03}.png"]
WIDTH, HEIGHT = 54, 36


def pictures(n: int, *, size: tuple[int, int] = (WIDTH, HEIGHT), transparent: bool = False) -> list[Pixels]:
    """Return pictures no two of which are alike in any part: a ramp that moves, and a corner that tells its number."""
    width, height = size
    y, x = np.mgrid[:height, :width]
    made = []
    for k in range(n):
        red, green = 255 * x // width, 255 * y // height
        blue = np.full_like(x, (40 * k) % 256)
        alpha = np.where(transparent & ((x + 5 * k) % 20 < 8), 0, 255)
        pixels = np.stack([red, green, blue, alpha], axis=-1).astype(np.uint8)
        pixels[: height // 3, : width // 4, :3] = (-13 * k % 256, 17 * k % 256, 0)
        pixels[pixels[..., 3] == 0] = 0
        made.append(pixels)
    return made


def sequence_of(made: list[Pixels], fps: float = 20) -> FrameSequence:
    height, width = made[0].shape[:2]
    is_opaque = all(picture[..., 3].min() == 255 for picture in made)
    return FrameSequence((width, height), len(made), fps, iter(made), partial(map, made.__getitem__), is_opaque)


def save(path: Path, made: list[Pixels], fps: float = 20) -> None:
    make_writer(path)(sequence_of(made, fps))


def read(path: Path) -> tuple[list[Pixels], list[float], Any]:
    """Return the pictures of a file that Pillow reads, their durations in milliseconds, and how often it plays."""
    shown, durations = [], []
    with Image.open(path) as image:
        for k in range(getattr(image, "n_frames", 1)):
            image.seek(k)
            image.load()
            shown.append(np.asarray(image.convert("RGBA")))
            durations.append(image.info["duration"])
        return shown, durations, image.info["loop"]


def watch(path: Path) -> tuple[list[Pixels], Any]:
    """Return the pictures of a video, and its stream's facts."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        shown = [np.asarray(frame.to_ndarray(format="rgb24"), np.uint8) for frame in container.decode(stream)]
        assert container.duration is not None
        facts = {
            "seconds": container.duration / av.time_base,
            "rate": stream.average_rate,
            "codec": stream.codec_context.name,
            "pixels": stream.codec_context.pix_fmt,
            "color": (stream.codec_context.colorspace, stream.codec_context.color_range),
        }
    return shown, facts


@pytest.mark.parametrize("kind", EXACT)
@pytest.mark.parametrize("transparent", [False, True])
@pytest.mark.parametrize("n", [1, 2, 12])
def test_exact_formats_give_back_every_byte(tmp_path: Path, kind: str, transparent: bool, n: int) -> None:
    made = pictures(n, transparent=transparent)
    save(tmp_path / f"out.{kind}", made)
    shown, durations, loop = read(tmp_path / f"out.{kind}")
    assert np.array_equal(shown, made)
    assert durations == [50] * n
    assert loop == 0  # for ever


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "unit_ms"), [("gif", 10), ("webp", 1), ("png", 0)])
@pytest.mark.parametrize("fps", [30, 24, 7, 50, 0.7])
def test_frames_begin_as_near_their_times_as_the_format_can_say(
    tmp_path: Path, kind: str, unit_ms: float, fps: float
) -> None:
    save(tmp_path / f"out.{kind}", pictures(10), fps)
    _, durations, _ = read(tmp_path / f"out.{kind}")
    begins, exact = np.cumsum(durations), np.arange(1, 11) * 1000 / fps
    assert np.abs(begins - exact).max() <= unit_ms / 2 + 1e-3
    if unit_ms:
        assert {duration % unit_ms for duration in durations} == {0}


def test_every_ending_is_known_in_any_case(tmp_path: Path) -> None:
    save(tmp_path / "OUT.GIF", pictures(2))
    with Image.open(tmp_path / "OUT.GIF") as image:
        assert (image.format, getattr(image, "n_frames", 1)) == ("GIF", 2)


@pytest.mark.parametrize("kind", VIDEO)
def test_videos_play_every_frame_at_its_time(tmp_path: Path, kind: str) -> None:
    made = pictures(25)
    save(tmp_path / f"out.{kind}", made, 12.5)
    shown, facts = watch(tmp_path / f"out.{kind}")
    assert len(shown) == 25
    assert facts["seconds"] == pytest.approx(2.0, abs=1e-3)
    assert facts["rate"] == Fraction(25, 2)
    assert facts["codec"] in {"mp4": ("h264",), "webm": ("vp9", "libvpx-vp9")}[kind]
    assert facts["pixels"] == "yuv420p"
    assert facts["color"] == (1, 1)  # BT.709, 16 to 235
    for k, picture in enumerate(shown):
        differences = [np.abs(picture.astype(int) - other[..., :3]).mean() for other in made]
        assert differences[k] <= 6
        assert int(np.argmin(differences)) == k


@pytest.mark.parametrize("kind", VIDEO)
def test_videos_play_in_a_browser(browser: Browser, tmp_path: Path, kind: str) -> None:
    save(tmp_path / f"out.{kind}", pictures(20))
    (tmp_path / "page.html").write_text(f"<!doctype html><video muted autoplay src='out.{kind}'></video>")
    browser.open(tmp_path / "page.html", (WIDTH, HEIGHT))
    browser.wait_for("document.querySelector('video').ended")
    facts = browser.evaluate("(v => [v.videoWidth, v.videoHeight, v.duration])(document.querySelector('video'))")
    assert facts == [WIDTH, HEIGHT, pytest.approx(1, abs=0.001)]


def test_an_mp4_begins_with_its_index(tmp_path: Path) -> None:
    save(tmp_path / "out.mp4", pictures(3))
    data = (tmp_path / "out.mp4").read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")


@pytest.mark.parametrize(("size", "padded"), [((33, 21), (34, 22)), ((33, 20), (34, 20)), ((32, 21), (32, 22))])
def test_an_mp4_of_odd_size_is_padded_with_a_warning(
    tmp_path: Path, size: tuple[int, int], padded: tuple[int, int]
) -> None:
    made = pictures(2, size=size)
    message = rf"MP4 holds even sizes only: {size[0]} x {size[1]} is padded to {padded[0]} x {padded[1]}"
    with pytest.warns(SizeWarning, match=message):
        save(tmp_path / "out.mp4", made)
    shown, _ = watch(tmp_path / "out.mp4")
    assert shown[0].shape == (padded[1], padded[0], 3)
    inside = shown[1][: size[1], : size[0]]
    assert np.abs(inside.astype(int) - made[1][..., :3]).mean() <= 6
    padding = shown[1][size[1] - 1 :, : size[0]]
    assert np.abs(padding.astype(int) - made[1][-1, :, :3]).mean() <= 8
    save(tmp_path / "out.webm", made)
    assert watch(tmp_path / "out.webm")[0][0].shape == (size[1], size[0], 3)


@pytest.mark.parametrize("kind", VIDEO)
def test_videos_refuse_what_is_transparent(tmp_path: Path, kind: str) -> None:
    with pytest.raises(ArgumentError, match=r"background must be opaque in (MP4|WebM): GIF, APNG, WebP and HTML"):
        save(tmp_path / f"out.{kind}", pictures(3, transparent=True))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", VIDEO)
def test_a_missing_extra_is_named_before_anything_is_drawn(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(MissingExtraError, match=r"^MP4 and WebM need PyAV: pip install 'gpu_xform\[video\]'$"):
        make_writer(tmp_path / f"out.{kind}")


def n_colors(*shown: Pixels) -> int:
    return len(np.unique(np.concatenate([np.ascontiguousarray(pixels).view(np.uint32).ravel() for pixels in shown])))


def line_art(color: tuple[int, int, int] = (214, 39, 40)) -> Pixels:
    """Return a picture of few flat colours with ramps between them, as the edges of lines have."""
    pixels = np.full((120, 160, 4), 255, np.uint8)
    ramp = np.linspace(0, 1, 60)[:, None]
    pixels[10:40, 20:80, :3] = color
    pixels[60:90, 20:80, :3] = np.round(np.array(color) * ramp + 255 * (1 - ramp))
    pixels[60:90, 90:150, :3] = np.round(np.array((31, 119, 180)) * ramp + np.array(color) * (1 - ramp))
    return pixels


def test_a_gif_of_few_colors_is_exact(tmp_path: Path) -> None:
    made = [line_art(), line_art()[::-1], line_art()[:, ::-1]]
    assert 100 < n_colors(*made) < 255
    save(tmp_path / "out.gif", made)
    shown, durations, loop = read(tmp_path / "out.gif")
    assert np.array_equal(shown, made)
    assert (durations, loop) == ([50, 50, 50], 0)


def test_a_gif_of_many_colors_keeps_flat_ones_and_dithers_none(tmp_path: Path) -> None:
    hues = [(250 - 11 * k, 9 * k, 40 + 7 * k) for k in range(20)]
    made = [line_art(hue) for hue in hues]
    assert n_colors(*made) > 1000
    save(tmp_path / "out.gif", made)
    shown, _, _ = read(tmp_path / "out.gif")
    assert len(shown) == 20
    for k, (picture, original) in enumerate(zip(shown, made, strict=True)):
        assert (picture[:10] == 255).all()
        assert n_colors(picture[10:40, 20:80]) == 1, "one colour has become several"
        assert np.abs(picture.astype(int) - original)[60:90, 20:150].mean() < 6, k
        # Down a ramp every column is of one colour, and so it is shown.
        assert (picture[60:90] == picture[60]).all()
    assert np.array_equal(shown[0][10:40], made[0][10:40])


def test_a_gif_has_one_palette(tmp_path: Path) -> None:
    made = pictures(5, size=(300, 200))
    assert n_colors(*made) > 1000
    save(tmp_path / "out.gif", made)
    shown, _, _ = read(tmp_path / "out.gif")
    assert 200 < n_colors(*shown) <= 255


def tables(path: Path) -> list[bytes]:
    """Return the table of colours that each frame of a GIF has of its own, empty where it has none."""
    data = path.read_bytes()
    found, place = [], 13 + 768
    while data[place : place + 1] != b";":
        is_frame = data[place : place + 1] == b","
        if is_frame:
            n_bytes = 3 << ((data[place + 9] & 7) + 1) if data[place + 9] & 0x80 else 0
            found.append(data[place + 10 : place + 10 + n_bytes])
        place += 11 + n_bytes if is_frame else 2
        while data[place]:
            place += 1 + data[place]
        place += 1
    return found


CUBE = gx.samples.cube()
# Fifteen frames, and colours are chosen from each second one.
FLASHES = {
    "faces": [gx.Layer(CUBE, fill=fill) for fill in ("red", "blue") * 8][:-1],
    "lines": [gx.Layer(CUBE, color=color) for color in ("red", "blue") * 8][:-1],
    "a strip of one face": [gx.Layer(CUBE, fill="face", transform=gx.scale(1, s, 1)) for s in (0.02, 1) * 8][:-1],
}


@pytest.mark.slow
@pytest.mark.parametrize("layers", FLASHES.values(), ids=list(FLASHES))
@pytest.mark.parametrize("background", ["white", None])
def test_a_gif_s_colors_are_kept_in_frames_that_none_were_chosen_from(
    tmp_path: Path, layers: list[gx.Layer], background: str | None
) -> None:
    animation = gx.animate(CUBE, layers, tmp_path / "out.gif", size=(120, 90), background=background)
    shown, _, _ = read(tmp_path / "out.gif")
    for picture, frame in zip(shown, animation, strict=True):
        original = np.asarray(frame)
        is_seen = original[..., 3] >= 128
        assert np.abs(picture[is_seen].astype(int) - original[is_seen])[:, :3].max() <= 8


@pytest.mark.slow
def test_a_gif_s_colors_may_change_bit_by_bit(tmp_path: Path) -> None:
    fades = [gx.Layer(CUBE, fill=(k / 59, 1 - k / 59, 0), transform=gx.rotate((1, 2, 3), k / 9)) for k in range(60)]
    animation = gx.animate(CUBE, fades, tmp_path / "out.gif", size=(120, 90))
    shown, _, _ = read(tmp_path / "out.gif")
    for k, (picture, frame) in enumerate(zip(shown, animation, strict=True)):
        is_filled = (np.asarray(frame)[..., :3] == np.round(np.array([k / 59, 1 - k / 59, 0]) * 255)).all(axis=-1)
        assert np.count_nonzero(is_filled) > 1000
        assert np.abs(picture.astype(int) - np.asarray(frame))[is_filled].max() <= 8, k


def test_a_gif_s_frame_has_a_local_table_if_the_common_one_is_not_acceptable(tmp_path: Path) -> None:
    gx.animate(CUBE, FLASHES["faces"], tmp_path / "out.gif", size=(120, 90))
    own = tables(tmp_path / "out.gif")
    assert [bool(table) for table in own] == [False, True] * 7 + [False]
    assert len(set(own[1::2])) == 1


@pytest.mark.slow
@pytest.mark.parametrize("size", [(60, 45), (240, 180)])
@pytest.mark.parametrize("style", [{"color": "face", "line_width": 1.5}, {"fill": "face", "depth_cue": 0.7}], ids=str)
def test_a_gif_s_antialiased_edges_need_no_local_tables(
    tmp_path: Path, size: tuple[int, int], style: dict[str, Any]
) -> None:
    gx.turntable(gx.samples.snub_dodecahedron(), 40, tmp_path / "out.gif", axis=(1, 2, 3), size=size, **style)
    assert 200 < n_colors(*read(tmp_path / "out.gif")[0]) <= 255
    assert not any(tables(tmp_path / "out.gif"))


def test_a_gif_is_the_same_however_many_processors_there_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for n_processors in (2, 8):
        monkeypatch.setattr(os, "cpu_count", lambda n=n_processors: n)
        gx.animate(CUBE, FLASHES["faces"], tmp_path / f"{n_processors}.gif", size=(120, 90))
    assert (tmp_path / "2.gif").read_bytes() == (tmp_path / "8.gif").read_bytes()


def test_a_gif_keeps_what_does_not_change(tmp_path: Path) -> None:
    """Not a pixel is written anew in a palette that holds another colour."""
    made = [np.full((HEIGHT, WIDTH, 4), (0, 0, 40 * (k in (1, 2, 3)), 255), np.uint8) for k in range(30)]
    save(tmp_path / "out.gif", made)
    assert np.array_equal(read(tmp_path / "out.gif")[0], made)


def test_a_gif_is_opaque_or_not_at_each_pixel(tmp_path: Path) -> None:
    made = pictures(4, transparent=True)
    made[1][5:9, 30:40, 3] = 127
    made[1][9:12, 30:40, 3] = 128
    save(tmp_path / "out.gif", made)
    shown, _, _ = read(tmp_path / "out.gif")
    for picture, original in zip(shown, made, strict=True):
        # What was there before is gone: the stripes move.
        assert np.array_equal(picture[..., 3], np.where(original[..., 3] >= 128, 255, 0))


def test_a_gif_shows_what_is_transparent_in_few_frames(tmp_path: Path) -> None:
    """Every second frame is covered, and so is each that its colours are chosen from."""
    zooms = [gx.scale(50), gx.scale(0.5)] * 7 + [gx.scale(50)]
    window = gx.Camera.window((-1, 1), (-1, 1))
    grid = gx.samples.grid(2)
    animation = gx.animate(grid, zooms, size=(60, 45), background=None, camera=window, fill="red")
    animation.save(tmp_path / "out.gif")
    shown, _, _ = read(tmp_path / "out.gif")
    for k, picture in enumerate(shown):
        assert np.array_equal(picture[..., 3] == 255, np.asarray(animation.frame(k))[..., 3] >= 128), k
        assert tuple(picture[2, 2]) == ((255, 0, 0, 255) if k % 2 == 0 else (0, 0, 0, 0)), k


@pytest.mark.parametrize("transparent", [False, True])
def test_a_gif_holds_of_each_frame_what_differs_from_what_is_below(tmp_path: Path, transparent: bool) -> None:
    ground = (0, 0, 0, 0) if transparent else (250, 240, 230, 255)
    places = [(3, 5), (9, 20), (9, 20), None, None, (30, 40)]  # row and column of a patch of 4 rows and 7 columns
    made = []
    for place in places:
        pixels = np.full((HEIGHT, WIDTH, 4), ground, np.uint8)
        if place:
            pixels[place[0] : place[0] + 4, place[1] : place[1] + 7] = (10, 20, 200, 255)
        made.append(pixels)
    save(tmp_path / "out.gif", made)
    shown, durations, _ = read(tmp_path / "out.gif")
    assert np.array_equal(shown, made)
    assert durations == [50] * 6
    nothing = (0, 0, 1, 1)
    patches = [nothing if place is None else (place[1], place[0], place[1] + 7, place[0] + 4) for place in places]
    changes = [(0, 0, WIDTH, HEIGHT), (5, 3, 27, 13), nothing, (20, 9, 27, 13), nothing, (40, 30, 47, 34)]
    with Image.open(tmp_path / "out.gif") as image:
        for k, expected in enumerate(patches if transparent else changes):
            image.seek(k)
            assert image.tile[0][1] == expected, k


@pytest.mark.slow
@pytest.mark.parametrize("side", [10, 24])
@pytest.mark.parametrize("color", [(255, 0, 0), (51, 107, 51)])
def test_a_small_patch_of_a_colour_that_is_not_sampled_is_shown_in_it(
    tmp_path: Path, side: int, color: tuple[int, int, int]
) -> None:
    """Two bars that move make nearly all of each frame differ from the last: the patch is a tiny part of that."""
    made = []
    for k in range(60):
        pixels = np.full((240, 320, 4), 255, np.uint8)
        pixels[5:235, 4 + k : 10 + k, :3] = 51
        pixels[5:235, 240 + k : 246 + k, :3] = 153
        pixels[100 : 100 + side, 150 : 150 + side, :3] = color if k in range(2, 7) else 51
        pixels[200:, 150:180, 0] = np.linspace(0, 255, 30)  # the palette is full
        pixels[200:, 150:180, 1] = np.linspace(0, 255, 40)[:, None]
        made.append(pixels)
    save(tmp_path / "out.gif", made)
    shown, _, _ = read(tmp_path / "out.gif")
    for k in range(2, 7):
        patch = shown[k][100 : 100 + side, 150 : 150 + side, :3]
        assert np.abs(patch.astype(int) - color).max() <= 8, k


def test_a_gif_s_delays_are_none_that_browsers_take_for_a_mistake(tmp_path: Path) -> None:
    save(tmp_path / "out.gif", pictures(3), 50)
    with pytest.raises(ArgumentError, match="fps must be at most 50 in a GIF, got 51"):
        save(tmp_path / "faster.gif", pictures(3), 51)
    assert [path.name for path in tmp_path.iterdir()] == ["out.gif"]


@pytest.mark.parametrize(
    ("kind", "name"), [("png", "an animated PNG"), ("apng", "an animated PNG"), ("webp", "a WebP")]
)
def test_frames_are_not_shorter_than_browsers_show_them(tmp_path: Path, kind: str, name: str) -> None:
    save(tmp_path / f"out.{kind}", pictures(5), 90)
    _, durations, _ = read(tmp_path / f"out.{kind}")
    assert min(durations) > 10.9
    with pytest.raises(ArgumentError, match=f"fps must be at most 90 in {name}, got 120"):
        save(tmp_path / f"faster.{kind}", pictures(3), 120)
    assert [path.name for path in tmp_path.iterdir()] == [f"out.{kind}"]


@pytest.mark.parametrize(
    ("name", "side"),
    [("out.gif", 65535), ("out.webp", 16383), ("out.html", 16383), ("out.mp4", 16384), ("out.webm", 65535)],
)
def test_a_size_that_the_format_cannot_hold(tmp_path: Path, name: str, side: int) -> None:
    sequence = FrameSequence((2, side + 1), 1, 20.0, failing([], after=0), partial(map, [].__getitem__), True)
    with pytest.raises(ArgumentError, match=rf"size must be at most {side} x {side} in .*, got 2 x {side + 1}"):
        make_writer(tmp_path / name)(sequence)
    assert list(tmp_path.iterdir()) == []


def test_a_size_that_the_encoder_refuses_is_an_error_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gpu_xform.animation.encoders import video

    monkeypatch.setattr(video, "MP4", video.VideoFormat("MP4", "mp4", "libx264", {}, side_multiple=1))
    with pytest.raises(ArgumentError, match="MP4: libx264 cannot encode 33 x 21 at 20 frames per second"):
        save(tmp_path / "out.mp4", pictures(1, size=(33, 21)))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("template", "names"),
    [
        ("f{frame}.png", ["f0.png", "f1.png", "f2.png"]),
        ("{frame:04}.png", ["0000.png", "0001.png", "0002.png"]),
        ("a-{frame:2}-b.PNG", ["a- 0-b.PNG", "a- 1-b.PNG", "a- 2-b.PNG"]),
    ],
)
def test_one_file_per_frame(tmp_path: Path, template: str, names: list[str]) -> None:
    made = pictures(3, transparent=True)
    save(tmp_path / "frames" / template, made)
    assert [path.name for path in tmp_path.iterdir()] == ["frames"]
    assert sorted(path.name for path in (tmp_path / "frames").iterdir()) == names
    for name, original in zip(names, made, strict=True):
        with Image.open(tmp_path / "frames" / name) as image:
            assert (image.format, getattr(image, "n_frames", 1)) == ("PNG", 1)
            assert np.array_equal(np.asarray(image), original)


def test_what_else_is_in_the_folder_stays(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "1.png").write_text("older")
    save(tmp_path / "{frame}.png", pictures(2))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.png", "1.png", "notes.txt"]
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / "1.png").read_bytes().startswith(b"\x89PNG")


def folder_of_frames(folder: Path) -> dict[str, bytes | str]:
    """Fill a folder with what older frames and others left there, and return its contents."""
    (folder / "0.png").write_text("older")
    (folder / "1.png").symlink_to("notes.txt")
    (folder / "notes.txt").write_text("mine")
    return contents(folder)


def contents(folder: Path) -> dict[str, bytes | str]:
    return {
        path.name: str(path.readlink()) if path.is_symlink() else b"" if path.is_dir() else path.read_bytes()
        for path in folder.iterdir()
    }


@pytest.mark.parametrize("is_there", [True, False], ids=["a folder that is there", "a new folder"])
def test_one_run_at_a_time_writes_the_frames_of_a_folder(tmp_path: Path, is_there: bool) -> None:
    folder = tmp_path / "frames"
    if is_there:
        folder.mkdir()
    first, second = pictures(3), pictures(3, transparent=True)
    told: list[str] = []

    def frames() -> Iterator[Pixels]:
        yield first[0]
        for name in ("{frame}.png", "{frame:02}.png"):
            with pytest.raises(ArgumentError) as caught:
                save(folder / name, second)
            told.append(str(caught.value))
        save(folder / "other{frame}.png", second)
        with pytest.raises(ArgumentError, match=r"which process .* is at"):
            save(folder / "{frame}.png", second)
        yield from first[1:]

    sequence = FrameSequence((WIDTH, HEIGHT), 3, 20.0, frames(), partial(map, first.__getitem__), True)
    make_writer(folder / "{frame}.png")(sequence)
    holder = f"process {os.getpid()} on {socket.gethostname()}"
    assert told == [f"path must be written by one run at a time, got {str(folder)!r}, which {holder} is at"] * 2
    assert sorted(contents(folder)) == [f"{prefix}{k}.png" for prefix in ("", "other") for k in range(3)]
    for k, picture in enumerate(first):
        with Image.open(folder / f"{k}.png") as image:
            assert np.array_equal(np.asarray(image), picture)
    assert os.listdir(tmp_path) == ["frames"]  # noqa: PTH208


def test_a_lock_that_a_killed_run_left_hinders_nobody(tmp_path: Path) -> None:
    for killed in (True, False):
        program = (
            "import os, signal, sys\n"
            "from gpu_xform._core.atomic_files import atomic_folder\n"
            "with atomic_folder(sys.argv[1], ['0.png'], '{frame}.png') as folder:\n"
            f"    {'os.kill(os.getpid(), signal.SIGKILL)' if killed else 'pass'}\n"
        )
        subprocess.run([sys.executable, "-c", program, tmp_path], check=not killed, timeout=60)
        assert bool(list(tmp_path.glob(".*.lock"))) == killed


def test_a_folder_where_a_frame_should_be_is_said_before_anything_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "2.png").mkdir()
    before = folder_of_frames(tmp_path)
    made = pictures(4)
    sequence = FrameSequence((WIDTH, HEIGHT), 4, 20.0, failing(made, after=0), partial(map, made.__getitem__), True)
    with pytest.raises(IsADirectoryError) as caught:
        make_writer(tmp_path / "{frame}.png")(sequence)
    assert caught.value.filename == str(tmp_path / "2.png")
    assert contents(tmp_path) == before


def test_a_folder_that_is_made_meanwhile_stops_all_frames(tmp_path: Path) -> None:
    before = folder_of_frames(tmp_path)
    made = pictures(4)

    def frames() -> Iterator[Pixels]:
        yield from made
        (tmp_path / "2.png").mkdir()
        (tmp_path / "2.png" / "mine").touch()

    sequence = FrameSequence((WIDTH, HEIGHT), 4, 20.0, frames(), partial(map, made.__getitem__), True)
    with pytest.raises(IsADirectoryError) as caught:
        make_writer(tmp_path / "{frame}.png")(sequence)
    assert caught.value.filename == str(tmp_path / "2.png")
    assert contents(tmp_path) == before | {"2.png": b""}
    assert (tmp_path / "2.png" / "mine").exists()


@pytest.mark.parametrize("moves", range(7))
@pytest.mark.parametrize("happens", [False, True])
@pytest.mark.parametrize("error", [KeyboardInterrupt(), PermissionError(errno.EACCES, "Permission denied")])
def test_frames_that_cannot_be_put_in_place_are_taken_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moves: int, happens: bool, error: BaseException
) -> None:
    """Wherever it stops, before a move or just after it, all that was there is there again."""
    before = folder_of_frames(tmp_path)
    rename, calls = Path.rename, []

    def stopping(path: Path, place: Path) -> Path:
        calls.append(place)
        if len(calls) == moves + 1 and happens:
            rename(path, place)
        if len(calls) == moves + 1:
            raise error
        return rename(path, place)

    monkeypatch.setattr(Path, "rename", stopping)
    if moves < 6:  # two that are replaced, and four that come
        with pytest.raises(type(error)):
            save(tmp_path / "{frame}.png", pictures(4))
        assert contents(tmp_path) == before
    else:
        save(tmp_path / "{frame}.png", pictures(4))
        assert sorted(contents(tmp_path)) == ["0.png", "1.png", "2.png", "3.png", "notes.txt"]
        assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    "name",
    ["{}.png", "{k}.png", "{frame:x}.png", "{frame:.2}.png", "{frame}{frame}.png", "{frame.png", "{frame!r}.png"],
)
def test_a_template_that_is_none(tmp_path: Path, name: str) -> None:
    with pytest.raises(ArgumentError, match=r"path must hold \{frame\}, or \{frame:04\}"):
        make_writer(tmp_path / name)


def test_a_template_is_for_png(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match=r"path must end in \.png if it holds \{frame\}, got '\{frame\}\.jpg'"):
        make_writer(tmp_path / "{frame}.jpg")


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_that_there_is_not_is_said_before_anything_is_drawn(tmp_path: Path, name: str) -> None:
    made: list[Pixels] = pictures(2)
    sequence = FrameSequence((WIDTH, HEIGHT), 2, 20.0, failing(made, after=0), partial(map, made.__getitem__), True)
    path = tmp_path / "none" / "at all" / name
    with pytest.raises(FileNotFoundError) as caught:
        make_writer(path)(sequence)
    assert str(tmp_path / "none") in str(caught.value)
    assert "tmp'" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_link_to_nowhere_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "frames").symlink_to(tmp_path / "nowhere")
    sequence = FrameSequence((WIDTH, HEIGHT), 2, 20.0, failing(pictures(2), after=0), iter, is_opaque=True)  # type: ignore[arg-type]
    with pytest.raises(NotADirectoryError, match="frames"):
        make_writer(tmp_path / "frames" / "{frame}.png")(sequence)
    assert [path.name for path in tmp_path.iterdir()] == ["frames"]


@pytest.mark.parametrize("at", [1, 2, 5])
def test_an_interrupt_while_frames_move_into_their_folder_comes_after_the_last(
    tmp_path: Path, at: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for k in range(3):
        (tmp_path / f"{k}.png").write_text("older")
    moves, rename = [], Path.rename

    def interrupted(path: Path, target: Path) -> Path:
        moves.append(path)
        if len(moves) == at:
            signal.raise_signal(signal.SIGINT)
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save(tmp_path / "{frame}.png", pictures(4))
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"{k}.png" for k in range(4)]
    assert all((tmp_path / f"{k}.png").read_bytes().startswith(b"\x89PNG") for k in range(4))


def test_a_file_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "frames").write_text("mine")
    with pytest.raises(NotADirectoryError, match="frames"):
        make_writer(tmp_path / "frames" / "{frame}.png")(sequence_of(pictures(2)))
    assert (tmp_path / "frames").read_text() == "mine"


def test_a_full_disk_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "out.gif").symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left") as caught:
        save(tmp_path / "out.gif", pictures(20, size=(200, 200)))
    assert caught.value.filename == str(tmp_path / "out.gif")


def test_a_full_disk_names_the_files_of_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Path, __: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", refuse)
    with pytest.raises(OSError, match="No space left") as caught:
        save(tmp_path / "{frame}.png", pictures(2))
    assert caught.value.filename == str(tmp_path / "{frame}.png")
    assert list(tmp_path.iterdir()) == []


def piped(pipe: Path, write: Callable[[Path], None]) -> bytes:
    """Return what another process reads from a named pipe while `write` is called with its path."""
    os.mkfifo(pipe)
    with subprocess.Popen(["/bin/cat", pipe], stdout=subprocess.PIPE) as cat:
        assert cat.stdout is not None
        with ThreadPoolExecutor(1) as reading:
            received = reading.submit(cat.stdout.read)
            write(pipe)
            return received.result(timeout=30)


@pytest.mark.skipif(sys.platform == "win32", reason="needs a named pipe")
@pytest.mark.parametrize("kind", ENCODERS)
def test_a_pipe_takes_what_a_file_takes(tmp_path: Path, kind: str) -> None:
    made = pictures(5)
    save(tmp_path / f"file.{kind}", made)
    pipe = tmp_path / f"pipe.{kind}"
    received = piped(pipe, lambda path: save(path, made))
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    if kind == "webm":  # each has a number of its own
        (tmp_path / "received.webm").write_bytes(received)
        assert np.array_equal(watch(tmp_path / "received.webm")[0], watch(tmp_path / "file.webm")[0])
    else:
        assert received == (tmp_path / f"file.{kind}").read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="needs a named pipe")
@pytest.mark.parametrize("kind", ENCODERS)
def test_what_stops_the_drawing_ends_the_pipe(tmp_path: Path, kind: str) -> None:
    made = pictures(2)
    sequence = FrameSequence((WIDTH, HEIGHT), 2, 20.0, failing(made, after=1), partial(map, made.__getitem__), True)

    def stopped(path: Path) -> None:
        with pytest.raises(RuntimeError, match="the device is gone"):
            make_writer(path)(sequence)

    assert len(piped(tmp_path / f"pipe.{kind}", stopped)) < 5000


def failing(made: list[Pixels], after: int, error: BaseException | None = None) -> Iterator[Pixels]:
    yield from made[:after]
    raise error or RuntimeError("the device is gone")


@contextlib.contextmanager
def leaving_nothing(folder: Path) -> Iterator[None]:
    """Check that a block leaves neither a file nor a thread."""
    before = sorted(folder.rglob("*"))
    yield
    assert sorted(folder.rglob("*")) == before
    assert not [thread.name for thread in threading.enumerate() if thread.name.startswith("gpu_xform")]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("after", [0, 1, 15])
@pytest.mark.parametrize("error", [RuntimeError("the device is gone"), KeyboardInterrupt()])
def test_what_stops_the_drawing_leaves_nothing(tmp_path: Path, name: str, after: int, error: BaseException) -> None:
    made = pictures(20)
    sequence = FrameSequence(
        (WIDTH, HEIGHT), 20, 20.0, failing(made, after, error), partial(map, made.__getitem__), True
    )
    with leaving_nothing(tmp_path), pytest.raises(type(error)):
        make_writer(tmp_path / name)(sequence)


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith(VIDEO)])
def test_what_goes_wrong_while_encoding_stops_the_drawing(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    encoder = "tobytes" if name.endswith(".gif") else "save"
    whole, calls = getattr(Image.Image, encoder), []

    def sometimes(image: Image.Image, *args: Any, **options: Any) -> Any:
        calls.append(image)
        if len(calls) > 3:
            raise MemoryError("no room for the fourth")
        return whole(image, *args, **options)

    monkeypatch.setattr(Image.Image, encoder, sometimes)
    made, drawn = pictures(100), []

    def frames() -> Iterator[Pixels]:
        for picture in made:
            drawn.append(picture)
            yield picture

    with leaving_nothing(tmp_path), pytest.raises(MemoryError, match="no room for the fourth"):
        make_writer(tmp_path / name)(
            FrameSequence((WIDTH, HEIGHT), 100, 20.0, frames(), partial(map, made.__getitem__), True)
        )
    assert len(drawn) <= 4 + MAX_WORKERS + 1


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith(VIDEO)])
@pytest.mark.parametrize("n_processors", [1, 2, 3])
def test_frames_are_encoded_in_threads_if_drawing_leaves_processors(
    tmp_path: Path, name: str, n_processors: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    encoder = "tobytes" if name.endswith(".gif") else "save"
    whole, threads = getattr(Image.Image, encoder), set()

    def noted(image: Image.Image, *args: Any, **options: Any) -> Any:
        threads.add(threading.current_thread())
        return whole(image, *args, **options)

    monkeypatch.setattr(Image.Image, encoder, noted)
    monkeypatch.setattr(os, "cpu_count", lambda: n_processors)
    save(tmp_path / name, pictures(20))
    assert (threads == {threading.current_thread()}) == (name.endswith(".gif") and n_processors < 3)
    assert len(threads) <= n_processors


def test_pictures_are_drawn_while_others_are_encoded() -> None:
    """Neither waits for the other: the sixth is drawn before the first is encoded, were there workers enough."""
    at_work, told = threading.Event(), threading.Event()

    def encode(k: Any) -> Any:
        at_work.set()
        assert told.wait(10), "nothing is drawn meanwhile"
        return k

    def frames() -> Iterator[Any]:
        yield 0
        assert at_work.wait(10), "nothing is encoded meanwhile"
        told.set()
        yield 1

    with encode_parallel(frames(), encode, n_workers=1) as results:
        assert list(results) == [0, 1]


def test_results_come_in_the_order_of_the_frames() -> None:
    def slow(k: Any) -> Any:
        time.sleep(0.02 * (k % 3 == 0))
        return k

    with encode_parallel(iter(range(40)), slow) as results:  # type: ignore[arg-type]
        assert list(results) == list(range(40))


def test_one_after_another_is_encoded_where_the_order_counts() -> None:
    inside, most = [0], [0]

    def encode(k: Any) -> Any:
        inside[0] += 1
        most[0] = max(most[0], inside[0])
        time.sleep(0.002)
        inside[0] -= 1
        return k

    with encode_parallel(iter(range(20)), encode, n_workers=1) as results:  # type: ignore[arg-type]
        assert list(results) == list(range(20))
    assert most == [1]


@pytest.mark.parametrize("name", NAMES)
def test_few_frames_are_held_at_a_time(tmp_path: Path, name: str) -> None:
    alive: list[int] = []
    living: list[weakref.ref[Any]] = []

    def drawn(k: int) -> Pixels:
        alive.append(sum(reference() is not None for reference in living))
        picture = pictures(1)[0]
        picture[0, 0, 0] = k
        living.append(weakref.ref(picture))
        return picture

    make_writer(tmp_path / name)(
        FrameSequence((WIDTH, HEIGHT), 50, 20.0, (drawn(k) for k in range(50)), partial(map, drawn), True)
    )
    assert len(alive) >= 50
    assert max(alive[8:]) <= MAX_WORKERS + 3


MEMORY = """
import re, sys
import gpu_xform as gx
def peak():
    return int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1024
def save(n):
    for name in sys.argv[1:]:
        gx.turntable(gx.samples.cube(), n, name, size=(500, 400))
    return peak()
save(6)
print(save(6), save(36))
"""


@pytest.mark.slow
def test_a_process_does_not_grow_with_the_frames(tmp_path: Path) -> None:
    """Held, 30 more pictures of 0.8 MB would be 24 MB."""
    names = [tmp_path / name for name in NAMES if name != "out.apng"]
    # With a heap for each thread, the peak depends on which of them happen to work at the same time.
    one_heap = {**os.environ, "MALLOC_ARENA_MAX": "1"}
    command = [sys.executable, "-c", MEMORY, *map(str, names)]
    ran = subprocess.run(command, capture_output=True, text=True, check=True, env=one_heap)
    few, many = map(float, ran.stdout.split())
    assert many - few < 12


INTERRUPTED = """
import sys, threading
import gpu_xform as gx
def told(done, total):
    if done == 5:
        print("drawing", flush=True)
try:
    camera = gx.Camera.look_at((0, 0, 5), (0, 0, 0))
    gx.turntable(gx.samples.cube(), 10_000, sys.argv[1], size=(200, 200), camera=camera, progress=told)
except KeyboardInterrupt:
    print("interrupted", [thread.name for thread in threading.enumerate() if "encoder" in thread.name])
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["out.gif", "out.mp4"])
def test_an_interrupt_leaves_no_file_and_no_thread(tmp_path: Path, name: str) -> None:
    child = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, tmp_path / name], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    with child:
        assert child.stdout is not None
        assert child.stdout.readline() == "drawing\n"
        child.send_signal(signal.SIGINT)
        told, errors = child.communicate(timeout=60)
    assert (told, errors, child.returncode) == ("interrupted []\n", "", 0)
    assert list(tmp_path.iterdir()) == []


def test_an_animation_goes_from_matrices_to_files(tmp_path: Path) -> None:
    """From matrices to the bytes of a file, exact where the format is, and near where it is not."""
    turns = [gx.rotate((1, 2, 3), 0.5 * k) for k in range(4)]
    animation = gx.animate(gx.samples.house(), turns, size=(120, 80), color="face", line_width=3)
    drawn = [np.asarray(frame) for frame in animation]
    for name in NAMES:
        animation.save(tmp_path / name)
    for kind in EXACT:
        assert np.array_equal(read(tmp_path / f"out.{kind}")[0], drawn)
    for k, picture in enumerate(drawn):
        with Image.open(tmp_path / f"out-{k:03}.png") as image:
            assert np.array_equal(np.asarray(image), picture)
    for kind in VIDEO:
        shown, _ = watch(tmp_path / f"out.{kind}")
        assert np.abs(np.stack(shown).astype(int) - np.stack(drawn)[..., :3]).mean() <= 6
    shown, _, _ = read(tmp_path / "out.gif")
    assert np.abs(np.stack(shown).astype(int) - np.stack(drawn)).mean() <= 1


def test_progress_is_told_and_a_bar_is_for_terminals(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    told: list[tuple[int, int]] = []
    animation = gx.turntable(gx.samples.cube(), 5, size=(20, 20))
    animation.save(tmp_path / "out.webp", progress=lambda done, total: told.append((done, total)))
    assert told == [(k, 5) for k in range(1, 6)]
    animation.save(tmp_path / "out.webp")
    assert capfd.readouterr() == ("", "")


def test_progress_that_raises_stops_it(tmp_path: Path) -> None:
    def stop(done: int, _: int) -> None:
        if done == 3:
            raise ValueError("enough")

    with leaving_nothing(tmp_path), pytest.raises(ValueError, match="enough"):
        gx.turntable(gx.samples.cube(), 50, tmp_path / "out.gif", size=(20, 20), progress=stop)


def held(device: GpuDevice) -> tuple[int, dict[tuple[str, str, int], list[int]]]:
    """Return what a device keeps: how many groups of buffers, and which buffers for whoever takes one."""
    spare = {role: sorted(buffer.id for buffer in buffers) for role, buffers in device.pool._spare.items()}
    return len(device.bind_groups), spare


def stop_at_7(done: int, _: int) -> None:
    if done == 7:
        raise ValueError("enough")


def turn_until_12(k: int) -> Any:
    if k == 12:
        raise ValueError("enough")
    return gx.rotate_y(k)


STOPS: list[dict[str, Any]] = [{"progress": stop_at_7}, {"frames": turn_until_12}]
MEMORIES = ["device", "staging_device", "staging_device", "device"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options", "memory"), [*zip(NAMES, cycle(STOPS), cycle(MEMORIES), strict=False)])
def test_what_stops_the_drawing_leaves_no_memory_taken(
    tmp_path: Path, name: str, options: dict[str, Any], memory: str, request: pytest.FixtureRequest
) -> None:
    device = request.getfixturevalue(memory)
    camera = gx.Camera.look_at((0, 0, 5), (0, 0, 0))
    drawing: dict[str, Any] = {"frames": gx.rotate_y, "n_frames": 20, "size": (64, 48), "camera": camera, **options}

    def stopped() -> None:
        with pytest.raises(ValueError, match="enough"):
            gx.animate(CUBE, path=tmp_path / name, device=device, **drawing)

    for _ in range(2):
        stopped()
    before = held(device)
    for _ in range(3):
        stopped()
    assert held(device) == before


def test_encoded_images_are_what_pillow_reads() -> None:
    picture = pictures(1, transparent=True)[0]
    for encode, name in [(encode_png, "PNG"), (encode_webp, "WEBP")]:
        with Image.open(io.BytesIO(encode(picture))) as image:
            assert image.format == name
            assert np.array_equal(np.asarray(image), picture)
