"""The first page of the docs: its lines run, and it names the extras, the packages and the drivers that there are."""

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.gpu import drivers

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "start.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def command_lines() -> list[str]:
    return [line for block in blocks("sh") for line in block.splitlines() if line.startswith("gpu-xform")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the Python lines of the page have run, one block after the other."""
    place = tmp_path_factory.mktemp("start")
    names: dict[str, Any] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        for block in blocks("python"):
            exec(compile(block, "start.md", "exec"), names)  # noqa: S102 - the page is ours
    assert_what_python_made(place, names)
    return place


def assert_what_python_made(place: Path, names: dict[str, Any]) -> None:
    points, matrix, moved, flat = (names[name] for name in ("points", "matrix", "moved", "flat"))
    assert moved.dtype == np.float32
    expected = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(moved, expected, rtol=0, atol=5e-6)
    np.testing.assert_allclose(flat[:, :2], expected[:, :2] / (1 - expected[:, 2:] / 8), rtol=0, atol=5e-6)
    turned = expected @ gx.rotate_x(0.1)[:3, :3].T
    np.testing.assert_allclose([names["low"], names["high"]], [turned.min(axis=0), turned.max(axis=0)], atol=5e-6)
    assert gx.load_mesh(place / "house.obj").n_faces == gx.samples.house().n_faces
    with Image.open(place / "cloud.png") as cloud:
        assert len(cloud.convert("RGB").getcolors(1 << 24) or ()) > 1000
    assert colors_in(place / "house.png") >= 4
    with Image.open(place / "dashed.png") as dashed:
        assert (np.asarray(dashed)[..., 0] < 128).sum() > 3000
    with Image.open(place / "teapot.png") as teapot:
        assert 1000 < (np.asarray(teapot)[..., 0] < 128).sum() < 10000
    assert '"nFrames": 40' in (place / "arm.html").read_text("utf-8")
    assert re.search(r'(?s)<title>house</title>.*#ffd700.*<g id="[^"]+">', names["drawing"])


def colors_in(picture: Path) -> int:
    """Count the colours of a picture that are on at least 100 pixels, the background left out."""
    with Image.open(picture) as image:
        colors = image.convert("RGB").getcolors(1 << 24)
    assert colors is not None
    return sum(count >= 100 for count, _ in colors) - 1


def test_every_block_is_run_or_of_a_known_kind() -> None:
    assert len(blocks("python")) == PAGE.count("```python") == 1
    assert PAGE.count("```") == 2 * (len(blocks("python")) + len(blocks("sh")))
    for block in blocks("sh"):
        assert all(line.startswith(("gpu-xform ", "pip ")) for line in block.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("line", command_lines())
def test_a_command_line(
    line: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = shlex.split(line)
    monkeypatch.chdir(folder)
    code = main(words[1:])
    ran = capsys.readouterr()
    assert (code, ran.err) == (0, "")
    house = gx.load_mesh(folder / "house.obj")
    match words[1]:
        case "render" if "-o" in words:
            picture = words[words.index("-o") + 1].format(model="house")
            assert colors_in(folder / picture) >= (4 if "face" in words else 1)
        case "render":
            assert "--reference" in words
        case "animate":
            with Image.open(folder / words[words.index("-o") + 1]) as image:
                assert getattr(image, "n_frames", 1) == 100
        case "simulate":
            with Image.open(folder / words[words.index("-o") + 1]) as image:
                assert getattr(image, "n_frames", 1) == 51
        case "transform":
            moved = gx.load_mesh(folder / words[3])
            assert moved.n_faces == house.n_faces
            flattened = "--perspective-from-eye" in words
            assert bool((moved.positions[:, 2] == 0).all()) == flattened
        case "convolve":
            with Image.open(folder / "house.png") as before, Image.open(folder / "soft.png") as after:
                assert np.array_equal(np.asarray(after), np.asarray(gx.convolve(before.copy(), gx.gaussian(2))))
        case "explain":
            assert ran.out.splitlines()[-1].split() == ["after", "M3", "[", "-0.8", "2.3", "0", "1", "]"]
        case "doctor":
            assert ran.out.endswith("Everything works.\n")
        case other:
            raise AssertionError(other)


def test_there_are_commands_to_run() -> None:
    assert [line.split()[1] for line in command_lines()] == [
        *("render", "render", "render", "render", "animate", "simulate", "transform", "transform"),
        *("convolve", "explain", "doctor"),
    ]


def test_the_page_and_the_error_message_advise_the_same() -> None:
    advice = set(re.findall(r"`sudo ([^`]+)`", PAGE))
    assert advice == set(drivers.PACKAGES.values())


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_page_lists_the_extras_there_are() -> None:
    table = re.search(r"^\| extra .*?\n\n", PAGE, re.MULTILINE | re.DOTALL)
    assert table is not None
    extras = set(PROJECT["optional-dependencies"])
    assert set(re.findall(r"^\| `(.+?)`", table[0], re.MULTILINE)) == extras
    named = re.findall(r"pip install '(.*?)\[(.*?)\]'", PAGE)
    assert {place for place, _ in named} == {"."}
    assert {extra for _, listed in named for extra in listed.split(",")} <= extras


def test_the_page_names_what_is_installed_besides() -> None:
    sentence = re.search(r"^This installs (.+?) as well\.", PAGE, re.MULTILINE | re.DOTALL)
    assert sentence is not None
    required = [re.split(r"[^\w-]", requirement)[0] for requirement in PROJECT["dependencies"]]
    assert re.findall(r"`([\w-]+)`", sentence[1]) == sorted(required)


def test_the_page_names_the_pythons_that_are_tested() -> None:
    classified = [words.split(" :: ")[2:] for words in PROJECT["classifiers"] if ":: Python :: 3." in words]
    versions = [version for (version,) in classified]
    assert PROJECT["requires-python"] == f">={versions[0]}"
    assert f"Python {versions[0]} or later ({versions[0]} to {versions[-1]} are tested)" in PAGE
