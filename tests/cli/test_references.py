"""Pictures held against references on the command line, as a test of one's models."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gpu_xform import Mesh, compare_images, samples, save_mesh
from gpu_xform.cli import main
from tests.support.cli import error_of

SIZE = ("--resolution", "120,80")


@pytest.fixture(autouse=True)
def _files() -> None:
    house = samples.house()
    save_mesh(house, "house.obj")
    save_mesh(Mesh(house.positions, house.faces[:-2]), "open.obj")  # the same points: the same camera
    assert render("house.obj", "-o", "expected.png") == 0


def render(*typed: str) -> int:
    return main(["render", *typed, *SIZE])


def render_error(capsys: pytest.CaptureFixture[str], *typed: str, code: int = 2) -> str:
    return error_of(["render", *typed, *SIZE], capsys, code)


def same(one: str, other: str) -> bool:
    return Path(one).read_bytes() == Path(other).read_bytes()


def test_a_picture_like_its_reference_passes_in_silence(capsys: pytest.CaptureFixture[str]) -> None:
    assert render("house.obj", "--reference", "expected.png", "--reference-diff", "diff.png") == 0
    assert render("house.obj", "--reference", "expected.png", "--reference-threshold", "0", "-o", "drawn.png") == 0
    assert capsys.readouterr() == ("", "")
    assert same("drawn.png", "expected.png")
    assert not Path("diff.png").exists()


def test_a_missing_wall_fails_with_its_own_code_and_figures(capsys: pytest.CaptureFixture[str]) -> None:
    assert render("open.obj", "-o", "drawn.png") == 0
    found = compare_images("drawn.png", "expected.png")
    Path("drawn.png").unlink()
    assert render("open.obj", "-o", "drawn.png", "--reference", "expected.png") == 4
    x, y = found.largest_at
    assert capsys.readouterr().err == (
        "gpu-xform: error: expected.png: the picture differs by more than 8 of 255 in "
        f"{found.n_pixels} pixels, 16 allowed; the largest difference is {found.largest}, at {x},{y}, "
        f"the mean {found.mean:.3g}; if it was drawn by a path with {{model}}, type that path: one picture per model "
        "has another default style\n"
    )
    assert 50 < found.n_pixels < 2000
    assert found.largest > 200
    assert Path("drawn.png").exists()


def test_pixels_and_their_tolerance_can_be_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    assert render("open.obj", "-o", "drawn.png") == 0
    found = compare_images("drawn.png", "expected.png")
    compared = ["open.obj", "--reference", "expected.png"]
    assert render(*compared, "--reference-pixels", str(found.n_pixels)) == 0
    assert f"{found.n_pixels - 1:,} allowed" in render_error(
        capsys, *compared, "--reference-pixels", str(found.n_pixels - 1), code=4
    )
    assert render(*compared, "--reference-threshold", str(found.largest)) == 0
    strict = ["--reference-threshold", str(found.largest - 0.5), "--reference-pixels", "0"]
    assert render(*compared, *strict) == 4
    largest = int((found.by_pixel == found.largest).sum())
    assert f"by more than {found.largest - 0.5:g} of 255 in {largest} pixels" in capsys.readouterr().err


def test_the_difference_is_drawn_where_there_is_one() -> None:
    assert render("open.obj", "--reference", "expected.png", "--reference-diff", "diff.png") == 4
    assert render("open.obj", "-o", "drawn.png") == 0
    with Image.open("diff.png") as image:
        assert np.array_equal(np.asarray(image), np.asarray(compare_images("drawn.png", "expected.png").image()))


def test_another_size_is_a_difference(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def load(_: object) -> None:
        raise AssertionError("it is decoded")

    monkeypatch.setattr("PIL.PngImagePlugin.PngImageFile.load", load)
    monkeypatch.setattr("gpu_xform.cli.references.MAX_SHOWN_PIXELS", 120 * 80 - 1)
    typed = ["render", "house.obj", "--reference", "expected.png", "--resolution", "80,120"]
    expected = "expected.png: the reference is 120 x 80 pixels, the picture 80 x 120"
    assert error_of(typed, capsys, 4) == f"gpu-xform: error: {expected}\n"
    assert main([*typed, "--report", "report.html"]) == 4


def test_a_missing_reference_says_how_it_is_made(capsys: pytest.CaptureFixture[str]) -> None:
    message = render_error(capsys, "house.obj", "--reference", "none.png", "-o", "drawn.png")
    assert message.startswith("gpu-xform: error: none.png: the reference does not exist; ")
    assert "--update-references makes it one" in message
    assert same("drawn.png", "expected.png")
    assert render("house.obj", "--reference", "none.png", "--update-references") == 0
    assert same("none.png", "expected.png")
    assert render("house.obj", "--reference", "none.png") == 0


def test_a_damaged_reference_is_wrong_input(capsys: pytest.CaptureFixture[str]) -> None:
    Path("expected.png").write_bytes(Path("expected.png").read_bytes()[:200])
    assert "--reference must be a PNG file, got 'expected.png'" in render_error(
        capsys, "house.obj", "--reference", "expected.png"
    )


def test_each_of_many_has_its_own_reference(capsys: pytest.CaptureFixture[str]) -> None:
    names = ["house", "cube", "solid", "new"]
    for name, mesh in (("cube", samples.cube()), ("solid", samples.snub_dodecahedron()), ("new", samples.cube())):
        save_mesh(mesh, f"{name}.obj")
    models = [f"{name}.obj" for name in names]
    assert render(*models[:3], "-o", "refs/{model}.png") == 0
    assert render(*models[:3], "--reference", "refs/{model}.png") == 0
    shutil.copy("refs/cube.png", "refs/solid.png")
    capsys.readouterr()
    diffs = ["--reference-diff", "diffs/{model}.png"]
    assert render(*models[:3], "--reference", "refs/{model}.png", *diffs) == 4
    complaint, summary = capsys.readouterr().err.splitlines()
    assert complaint.startswith("gpu-xform: error: solid.obj: refs/solid.png: the picture differs by more than")
    assert summary == "gpu-xform: 3 pictures: 2 done, 1 not matching the reference"
    assert [path.as_posix() for path in Path("diffs").iterdir()] == ["diffs/solid.png"]
    assert render(*models, "--reference", "refs/{model}.png", "-o", "drawn/{model}.png") == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines[1].startswith("gpu-xform: error: new.obj: refs/new.png: the reference does not exist")
    assert lines[2] == "gpu-xform: 4 pictures: 2 done, 1 failed, 1 not matching the reference"
    assert sorted(path.stem for path in Path("drawn").iterdir()) == sorted(names)


def test_one_reference_for_many_models(capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy("house.obj", "copy.obj")
    models = ["house.obj", "open.obj", "copy.obj"]
    assert render(*models, "--reference", "expected.png", "--line-width", "1.5", "--reference-diff", "{model}.png") == 4
    assert capsys.readouterr().err.splitlines()[1] == "gpu-xform: 3 pictures: 2 done, 1 not matching the reference"
    assert sorted(path.name for path in Path().glob("*.png")) == ["expected.png", "open.png"]


@pytest.mark.parametrize("written", [["-o", "./expected.png"], ["--reference-diff", "expected.png", "-o", "x.png"]])
def test_a_reference_is_never_written(written: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    before = Path("expected.png").read_bytes()
    assert "expected.png: a picture must not overwrite a reference" in render_error(
        capsys, "open.obj", "--reference", "expected.png", *written
    )
    assert Path("expected.png").read_bytes() == before
    assert not Path("x.png").exists()


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["-o", "x.png", "--reference-threshold", "3"], "--reference-threshold must come with --reference"),
        (["-o", "x.png", "--reference-pixels", "0"], "--reference-pixels must come with --reference"),
        (["-o", "x.png", "--reference-diff", "d.png"], "--reference-diff must come with --reference"),
        (["--reference", "expected.png", "--reference-threshold", "256"], "--reference-threshold: expected a number"),
        (["--reference", "expected.png", "--reference-threshold", "-1"], "--reference-threshold: expected a number"),
        (["--reference", "expected.png", "--reference-threshold", "nan"], "--reference-threshold: expected a number"),
        (["--reference", "expected.png", "--reference-pixels", "1.5"], "--reference-pixels: expected a whole number"),
        (["--reference", "expected.png", "--reference-pixels", "-1"], "--reference-pixels: expected a whole number"),
        (["--reference", "expected.png", "--reference-diff", "-"], "--reference-diff must be a file"),
        (["--reference", "expected.png", "--reference-diff", "d.bmp"], "d.bmp: the type must be one of png"),
        (
            ["--reference", "expected.png", "--reference-diff", "x.png", "-o", "x.png"],
            "two pictures would be written",
        ),
        ([], "-o must give the file of the picture, or --reference a picture to compare it with"),
    ],
)
def test_options_that_mean_nothing(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in render_error(capsys, "open.obj", *typed)
    assert sorted(path.name for path in Path().iterdir()) == ["expected.png", "house.obj", "open.obj"]


@pytest.mark.parametrize(("size", "allowed"), [("200,100", 18), ("99,100", 16), ("1024,1024", 120)])
def test_a_few_pixels_may_differ_as_other_adapters_make_them(
    size: str, allowed: int, capsys: pytest.CaptureFixture[str]
) -> None:
    typed = ["render", "house.obj", "--resolution", size]
    assert main([*typed, "-o", "expected.png"]) == 0
    picture = np.array(Image.open("expected.png"))
    for n, code in ((allowed, 0), (allowed + 1, 4)):
        changed = picture.copy()
        changed.reshape(-1, 4)[:n, 0] -= 9
        Image.fromarray(changed).save("expected.png")
        assert main([*typed, "--reference", "expected.png"]) == code
    assert f"{allowed} allowed" in capsys.readouterr().err
