"""`gpu-xform render` with text: labels from words and files, and their font."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import render_array, samples, save_mesh
from gpu_xform.cli import main
from tests.support.cli import read_png

SIZE = ("--resolution", "120,80")
HOUSE = samples.house()


@pytest.fixture(autouse=True)
def _files() -> None:
    save_mesh(HOUSE, "house.obj")
    np.save("heat.npy", np.arange(10.0))
    Path("corners.txt").write_text("first\n\nthird\n" + "\n" * 7, "utf-8")
    Path("some.csv").write_text('2,"ridge, left"\n\n0.5,0,1,Tür\n'.replace("ü", "u"), "utf-8")


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        (["--labels", "names"], {"labels": "names", "name": "house"}),
        (["--labels", "indices", "--font-size", "9"], {"labels": "indices", "font_size": 9}),
        (["--labels", "corners.txt"], {"labels": ["first", None, "third", *[None] * 7]}),
        (["--axes", "--legend"], {"axes": True, "legend": True, "name": "house"}),
        (["--axis-titles", "east,,north"], {"axes": ["east", "", "north"]}),
        (["--scalars", "y", "--colorbar"], {"scalars": HOUSE.positions[:, 1], "colorbar": "y"}),
        (["--scalars", "heat.npy", "--colorbar"], {"scalars": np.arange(10.0), "colorbar": "heat"}),
        (["--labels", "some.csv"], {"labels": {2: "ridge, left", (0.5, 0, 1): "Tur"}}),
    ],
)
def test_texts_are_what_the_library_draws(options: list[str], arguments: dict[str, Any]) -> None:
    assert main(["render", "house.obj", "-o", "out.png", *SIZE, *options]) == 0
    picture = render_array(HOUSE, size=(120, 80), **arguments)
    assert np.array_equal(read_png("out.png"), picture)
    assert not np.array_equal(render_array(HOUSE, size=(120, 80)), picture)


def test_the_parts_of_a_file_are_models_of_their_own(capsys: pytest.CaptureFixture[str]) -> None:
    scene = gx.Scene()
    for name, x in (("left", -2.0), ("right", 2.0)):
        scene.add(samples.cube(), name=name, transform=gx.translate(x, 0, 0))
    save_mesh(scene, "pair.glb")
    render = ["render", "pair.glb", "-o", "pair.svg", *SIZE, "--labels", "names"]
    assert main([*render, "--fill", "tan", "--parts", "--rotate-z", "10", "--instances", "one.npy"]) == 2
    np.save("one.npy", [gx.rotate_x(0.1)])
    assert main([*render, "--fill", "tan", "--parts", "--rotate-z", "10", "--instances", "one.npy"]) == 0
    text = Path("pair.svg").read_text("utf-8")
    read = gx.load_scene("pair.glb")
    turned = gx.rotate_z(10, degrees=True) @ np.load("one.npy")
    assert text == gx.render_svg(read, size=(120, 80), fill="tan", labels="names", transform=turned)
    assert ">left</text>" in text
    for options in (["--scalars", "x"], ["--vertex-colors", "heat.npy"], ["--edges", "heat.npy"]):
        assert main([*render, "--parts", *options]) == 2
        assert f"{options[0]}" in capsys.readouterr().err
    assert main(["render", "house.obj", "-o", "a.png", *SIZE]) == 0
    assert main(["render", "house.obj", "-o", "b.png", *SIZE, "--parts"]) == 0
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes()


def test_a_legend_tells_models_apart_that_have_no_colours() -> None:
    save_mesh(HOUSE, "shed.obj")
    render = ["render", "house.obj", "shed.obj", "-o", "both.svg", *SIZE, "--legend"]
    assert main(render) == 0
    layers = [gx.Layer(HOUSE, name=name, color=f"C{i}") for i, name in enumerate(("house", "shed"))]
    assert Path("both.svg").read_text("utf-8") == gx.render_svg(layers, size=(120, 80), legend=True)
    assert main([*render, "--color", "red"]) == 2


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--labels", "name"], "--labels: expected names or indices, or a .txt or .csv file, got 'name'; did you mean"),
        (["--labels", "none.txt"], "none.txt: No such file"),
        (["--labels", "short.txt"], "labels must have one text for each of the 10 points, got 1"),
        (["--labels", "wrong.csv"], "wrong.csv: line 2: expected INDEX,TEXT or X,Y,Z,TEXT, got '1,2,both'"),
        (["--labels", "latin.txt"], "latin.txt: expected text in UTF-8"),
        (["--colorbar"], "--colorbar must come with --scalars"),
        (["--axis-titles", "x,y"], "--axis-titles: expected three titles, X,Y,Z, got 'x,y'"),
        (["--font", "nonesuch"], "font must be the path or the name of a font, got 'nonesuch'"),
        (["--font-size", "0"], "--font-size: expected a positive number of pixels"),
    ],
)
def test_texts_that_cannot_be(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("short.txt").write_text("one\n", "utf-8")
    Path("wrong.csv").write_text("0,one\n1,2,both\n", "utf-8")
    Path("latin.txt").write_bytes(b"\xfc\n")
    assert main(["render", "house.obj", "-o", "out.png", *SIZE, *options]) == 2
    assert words in capsys.readouterr().err
    assert not Path("out.png").exists()
