"""`gpu-xform convolve`: image files through kernels."""

import io
import re
import struct
import zlib
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.cli.commands import convolve as command
from gpu_xform.compute.convolution.borders import Border
from gpu_xform.compute.convolution.convolve import Alpha
from gpu_xform.compute.convolution.filters import NAMED_KERNELS
from tests.support.cli import error_of, run_in_process
from tests.support.types import Array

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
RNG = np.random.default_rng(5)
RGB = RNG.integers(0, 256, (30, 40, 3), np.uint8)
GREY = np.ascontiguousarray(RGB[..., 0])
RGBA = RNG.integers(0, 256, (30, 40, 4), np.uint8)


@pytest.fixture(autouse=True)
def image_files(working_folder: Path) -> None:  # noqa: ARG001 - the working folder
    Image.fromarray(RGB).save("rgb.png")
    Image.fromarray(RGBA).save("rgba.png")
    Image.fromarray(GREY).save("grey.png")
    Path("kernel.txt").write_text("0 -1 0\n-1, 5, -1\n\n0 -1 0\n")
    Path("model.obj").write_text("v 0 0 0\n")


def convolved(*arguments: str, output: str = "out.png") -> Array:
    assert main(["convolve", arguments[0], output, *arguments[1:]]) == 0
    with Image.open(output) as image:
        return np.asarray(image)


@pytest.mark.parametrize(
    ("arguments", "kernel"),
    [
        (["--gaussian", "0.5"], gx.gaussian(0.5)),
        (["--gaussian", "0.4,0.7"], gx.gaussian((0.4, 0.7))),
        (["--box", "5"], gx.box_kernel(5)),
        (["--matrix", "0,-1,0; -1,5,-1; 0,-1,0"], NAMED_KERNELS["sharpen"]()),
        (["--matrix", "-1 3 -1"], np.array([[-1.0, 3.0, -1.0]])),
        (["--matrix", "kernel.txt"], NAMED_KERNELS["sharpen"]()),
        *((["--kernel", name], make()) for name, make in NAMED_KERNELS.items()),
    ],
    ids=str,
)
def test_an_image_through_a_kernel(arguments: list[str], kernel: Array) -> None:
    assert np.array_equal(convolved("rgb.png", *arguments), gx.convolve(RGB, kernel))


def test_grey_stays_grey() -> None:
    assert np.array_equal(convolved("grey.png", "--box", "3"), gx.convolve(GREY, gx.box_kernel(3)))


def test_options_are_keywords() -> None:
    kernel = gx.gaussian(0.4)
    assert np.array_equal(
        convolved("rgb.png", "--gaussian", "0.4", "--border", "wrap"), gx.convolve(RGB, kernel, border="wrap")
    )
    assert np.array_equal(convolved("rgb.png", "--gaussian", "0.4", "--linear"), gx.convolve(RGB, kernel, linear=True))
    assert np.array_equal(
        convolved("rgb.png", "--kernel", "sobel-x", "--correlate"), gx.correlate(RGB, gx.sobel_kernel())
    )
    assert np.array_equal(
        convolved("rgba.png", "--gaussian", "0.4", "--alpha", "independent"),
        gx.convolve(RGBA, kernel, alpha="independent"),
    )
    assert np.array_equal(convolved("rgba.png", "--gaussian", "0.4"), gx.convolve(RGBA, kernel))
    assert np.array_equal(
        convolved("rgba.png", "--kernel", "edges"), gx.convolve(RGBA, NAMED_KERNELS["edges"](), alpha="keep")
    )


def test_palettes_and_bits_become_colours() -> None:
    Image.fromarray(RGB).convert("P").save("palette.png")
    with Image.open("palette.png") as image:
        colors = np.asarray(image.convert("RGB"))
    assert np.array_equal(convolved("palette.png", "--box", "3"), gx.convolve(colors, gx.box_kernel(3)))
    Image.fromarray(RGB[..., 0]).convert("1").save("bits.png")
    assert convolved("bits.png", "--kernel", "identity").dtype == np.uint8
    Image.fromarray(RGB).save("keyed.png", transparency=tuple(RGB[0, 0].tolist()))
    assert convolved("keyed.png", "--kernel", "identity").shape == (30, 40, 4)


def test_sixteen_bits_stay() -> None:
    deep = RNG.integers(0, 65536, (30, 40), np.uint16)
    Image.fromarray(deep).save("deep.png")
    assert np.array_equal(convolved("deep.png", "--gaussian", "0.4"), gx.convolve(deep, gx.gaussian(0.4)))


def test_a_photo_is_upright() -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise
    Image.fromarray(RGB).save("photo.png", exif=exif)
    assert np.array_equal(convolved("photo.png", "--kernel", "identity"), np.rot90(RGB, -1))


@pytest.mark.parametrize("name", ["out.webp", "out.jpg", "out.tiff", "out.bmp"])
def test_other_types_are_written(name: str) -> None:
    assert convolved("rgb.png", "--box", "3", output=name).shape == (30, 40, 3)


def test_standard_streams_carry_png() -> None:
    result = run_in_process("convolve", "-", "-", "--box", "3", input=Path("rgb.png").read_bytes())
    assert (result.returncode, result.stderr) == (0, b"")
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(result.stdout))), gx.convolve(RGB, gx.box_kernel(3)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("rgb.png out.png", "one of the arguments --gaussian --box --kernel --matrix is required"),
        ("rgb.png out.png --box 3 --gaussian 1", "not allowed with argument"),
        ("rgb.png out.png --box 4", "--box: expected an odd number of pixels, got '4'"),
        ("rgb.png out.png --gaussian -1", "--gaussian: expected numbers that are 0 or more, got '-1'"),
        ("rgb.png out.png --kernel sharp", "--kernel: expected blur, edges, .*; did you mean 'sharpen'"),
        ("rgb.png out.png --matrix 1,2;3", "--matrix: expected rows of as many numbers, got '1,2;3'"),
        ("rgb.png out.png --matrix none.txt", "--matrix: expected rows of numbers or a file of them, got 'none.txt'"),
        ("rgb.png out.png --matrix 1,2;3,4", r"rgb.png: kernel must have odd sides, or an origin, got shape \(2, 2\)"),
        ("rgb.png out.png --box 101", "rgb.png: kernel must reach at most 29 rows beyond an image of 30"),
        ("rgb.png out.obj --box 3", "out.obj: the type must be one of bmp, jpeg, .*, got obj"),
        ("rgba.png out.jpg --box 3", "out.jpg: cannot write mode RGBA as JPEG"),
        ("model.obj out.png --box 3", "model.obj: it is not a picture that Pillow reads\n$"),
        ("none.png out.png --box 3", "none.png: No such file or directory"),
        ("rgb.png folder/out.png --box 3", "folder/out.png: No such file or directory"),
    ],
)
def test_what_is_wrong_is_said_in_one_line_and_nothing_is_written(
    arguments: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(Path().iterdir())
    error = error_of(["convolve", *arguments.split()], capsys)
    assert re.search(message, error), error
    assert sorted(Path().iterdir()) == before


def test_a_picture_may_have_twice_as_many_pixels_as_pillow_warns_of(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", GREY.size // 2)
    assert main(["convolve", "grey.png", "out.png", "--box", "3"]) == 0
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", GREY.size // 2 - 1)
    message = error_of(["convolve", "grey.png", "out.png", "--box", "3"], capsys)
    assert "grey.png: expected a picture that Pillow reads: Image size (1200 pixels) exceeds limit of 1198" in message


def test_what_pillow_warns_of_is_one_line_that_names_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    chunk = b"acTL" + bytes(8)  # of an animation of no frames
    data, end = Path("grey.png").read_bytes(), len(PNG_SIGNATURE) + 25
    animated = data[:end] + struct.pack(">I", 8) + chunk + struct.pack(">I", zlib.crc32(chunk)) + data[end:]
    Path("animated.png").write_bytes(animated)
    assert np.array_equal(convolved("animated.png", "--box", "3"), convolved("grey.png", "--box", "3"))
    warning = "gpu-xform: warning: animated.png: Invalid APNG, will use default PNG image if possible\n"
    assert capsys.readouterr() == ("", warning)


def test_the_choices_are_those_of_the_library() -> None:

    assert tuple(NAMED_KERNELS) == command.KERNELS
    assert get_args(Border) == command.BORDERS
    assert get_args(Alpha) == command.ALPHAS
