"""Pictures that stay as they are, and the helper that sees to it, held against pictures that are almost right."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, samples
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.names import RASTERIZERS
from tests.support.goldens import FAILURES, FOLDER, MAX_PIXELS, Goldens, driver_of
from tests.support.types import Pixels

SIZE = (240, 180)

PICTURES: dict[str, tuple[Mesh, dict[str, Any]]] = {
    "snub_dodecahedron_by_face": (
        samples.snub_dodecahedron(),
        {"camera": Camera.fit(samples.snub_dodecahedron()), "color": "face"},
    ),
    "house_in_perspective": (
        samples.house(),
        {
            "camera": Camera.look_at((2.7, 2.0, 5.0), (0.0, -0.08, 0.0), fov_y=40.0),
            "color": "#b04020",
            "line_width": 2.0,
        },
    ),
    "cube_in_thin_lines": (
        samples.cube(),
        {
            "camera": Camera.look_at((2.6, 1.9, 4.4), (0.0, -0.1, 0.0), fov_y=40.0),
            "color": "#204060",
            "background": "#ffffe0",
            "antialias": False,
        },
    ),
}


BLOCKS = np.stack([gx.chain(gx.rotate_y(0.3 * i), gx.scale(0.6), gx.translate(1.7 * i - 2.6, 0, -i)) for i in range(4)])

STYLED: dict[str, tuple[Any, dict[str, Any]]] = {
    "house_with_dashes": (
        samples.house(),
        {
            "camera": Camera.look_at((2.7, 2.0, 5.0), (0.0, -0.08, 0.0), fov_y=40.0),
            "color": "#208040",
            "hidden": "dash",
            "line_width": 2.0,
        },
    ),
    "snub_dodecahedron_filled": (samples.snub_dodecahedron(), {"fill": "face", "depth_cue": 0.8}),
    "instances_that_fade": (
        [
            Layer(samples.cube(), transform=BLOCKS, hidden="fade", color="#204080"),
            Layer(
                samples.icosphere(2),
                transform=gx.translate(0, 1.2, -1.5),
                hidden="fade",
                color="#c04020",
                line_width=1.0,
            ),
        ],
        {"camera": Camera.look_at((1.5, 3.0, 9.5), (-0.2, 0.3, -1.5))},
    ),
    "scalars_with_dots": (
        samples.torus(24, 12),
        {"scalars": samples.torus(24, 12).positions @ [0.2, 1.0, 0.4], "point_size": 5.0, "hidden": "remove"},
    ),
}
ALL: dict[str, tuple[Any, dict[str, Any]]] = {**PICTURES, **STYLED}


def draw(name: str, mesh: Mesh | None = None) -> Pixels:
    own, style = ALL[name]
    return gx.render_array(mesh or own, size=SIZE, **style)


@pytest.mark.parametrize("name", ALL)
def test_the_picture_is_the_golden_one(name: str, assert_golden: Callable[[Pixels, str], None]) -> None:
    assert_golden(draw(name), name)


def test_every_golden_is_still_drawn() -> None:
    assert {path.stem for path in FOLDER.glob("*.png")} == set(ALL)


HOME, ELSEWHERE = "llvmpipe, Mesa 22", "llvmpipe, Mesa 25"


@pytest.fixture(params=[HOME, ELSEWHERE])
def goldens(request: pytest.FixtureRequest, tmp_path: Path) -> Goldens:
    """An empty folder of goldens, at home and on another driver."""
    folder, output = tmp_path / "goldens", tmp_path / "of this run" / "failures"
    folder.mkdir()
    (folder / "driver.txt").write_text(f"{HOME}\n")
    return Goldens(folder, request.param, output)


def keep(goldens: Goldens, picture: Pixels, name: str = "picture") -> None:
    with pytest.raises(AssertionError, match=r"^wrote "):
        dataclasses.replace(goldens, driver=HOME, update=True).check(picture, name)


CHANGES: dict[str, Callable[[Pixels], Pixels]] = {
    "a column to the right": lambda picture: np.roll(picture, 1, axis=1),
    "a row down": lambda picture: np.roll(picture, 1, axis=0),
    "red for blue": lambda picture: picture[..., [2, 1, 0, 3]],
    "upside down": lambda picture: picture[::-1],
    "half as transparent": lambda picture: picture // np.array([1, 1, 1, 2], np.uint8),
}


@pytest.mark.slow
@pytest.mark.parametrize("rasterizer_name", RASTERIZERS[1:2], indirect=True)  # draws with both, or tests none
@pytest.mark.parametrize("name", ALL)
def test_a_changed_picture_fails(name: str, goldens: Goldens) -> None:
    picture = draw(name)
    keep(goldens, picture)
    goldens.check(picture, "picture")
    for change in CHANGES.values():
        with pytest.raises(AssertionError, match=r"^picture\.png differs by more than 1/255 in \d+ pixels of 43200, "):
            goldens.check(change(picture), "picture")


@pytest.mark.slow
@pytest.mark.parametrize("lost", [0, 5, 11])
@pytest.mark.parametrize("name", PICTURES)
def test_a_lost_edge_fails(name: str, lost: int, goldens: Goldens) -> None:
    mesh, _ = PICTURES[name]
    lost_last = np.roll(mesh.edges, -lost - 1, axis=0)  # the colours of the others stay
    keep(goldens, draw(name, Mesh(mesh.positions, lost_last)))
    with pytest.raises(AssertionError, match=r"^picture\.png differs by more than 1/255 in "):
        goldens.check(draw(name, Mesh(mesh.positions, lost_last[:-1])), "picture")


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_that_is_rounded_otherwise_everywhere_passes(name: str, goldens: Goldens) -> None:
    picture = draw(name)
    keep(goldens, picture)
    noise = np.random.default_rng(0).integers(-1, 2, picture.shape)
    other = np.clip(picture + noise, 0, 255).astype(np.uint8)
    assert (other != picture).mean() > 0.3
    goldens.check(other, "picture")


def test_a_few_other_pixels_pass_on_another_driver_only(goldens: Goldens) -> None:
    picture = np.full((180, 240, 4), 255, np.uint8)
    keep(goldens, picture)
    for n_pixels in (1, MAX_PIXELS, MAX_PIXELS + 1):
        other = picture.copy()
        other[40, :n_pixels, :3] = 100
        if goldens.driver == ELSEWHERE and n_pixels <= MAX_PIXELS:
            goldens.check(other, "picture")
        else:
            with pytest.raises(AssertionError, match=rf" in {n_pixels}, most by 155/255 in row 40, column 0, on "):
                goldens.check(other, "picture")


def test_a_change_too_faint_to_see_but_everywhere_fails(goldens: Goldens) -> None:
    picture = np.full((180, 240, 4), 255, np.uint8)
    keep(goldens, picture)
    with pytest.raises(
        AssertionError, match=r"differs by more than 1/255 in 43200 pixels of 43200, by more than 16/255 in 0"
    ):
        goldens.check(picture - np.uint8(2), "picture")


def test_a_missing_golden_fails_and_another_size_does(goldens: Goldens) -> None:
    picture = draw("cube_in_thin_lines")
    with pytest.raises(AssertionError, match=r"^there is no golden picture\.png\. "):
        goldens.check(picture, "picture")
    assert (np.asarray(Image.open(goldens.output / "picture.actual.png")) == picture).all()
    assert not (goldens.folder / "picture.png").exists()
    keep(goldens, picture)
    with pytest.raises(AssertionError, match=r"^picture\.png has shape \(180, 240, 4\), got \(180, 239, 4\)\. "):
        goldens.check(picture[:, 1:], "picture")


def test_a_failure_leaves_the_actual_the_expected_and_the_difference(goldens: Goldens) -> None:
    picture = np.full((180, 240, 4), 200, np.uint8)
    keep(goldens, picture)
    other = picture.copy()
    other[3:7, 30:130, 1] = 0
    other[100, 100, 2] = 201
    with pytest.raises(AssertionError) as caught:
        goldens.check(other, "picture")
    assert str(goldens.output) in str(caught.value)
    assert (np.asarray(Image.open(goldens.output / "picture.actual.png")) == other).all()
    difference = np.asarray(Image.open(goldens.output / "picture.difference.png"))
    assert ((difference > 0) == (other != picture).any(axis=-1)).all()
    assert difference[4, 40] > difference[100, 100] >= 64
    expected = np.asarray(Image.open(goldens.output / "picture.expected.png"))
    assert (expected == picture).all()
    with pytest.raises(AssertionError):
        goldens.check(other[1:], "picture")
    assert {path.name for path in goldens.output.iterdir()} == {"picture.actual.png", "picture.expected.png"}


def test_pictures_that_pass_leave_nothing(goldens: Goldens) -> None:
    picture = np.full((180, 240, 4), 200, np.uint8)
    keep(goldens, picture)
    goldens.check(picture, "picture")
    assert not goldens.output.exists()


def test_failures_of_the_suite_go_where_git_ignores_them_and_ci_keeps_them(suite_goldens: Goldens) -> None:
    assert suite_goldens.output == FAILURES
    left = FAILURES / "no_such_golden.actual.png"
    with pytest.raises(AssertionError, match="there is no golden no_such_golden"):
        dataclasses.replace(suite_goldens, update=False).check(np.zeros((2, 3, 4), np.uint8), "no_such_golden")
    assert left.is_file()
    left.unlink()
    root = FOLDER.parents[1]
    folder = FAILURES.relative_to(root)
    assert f"/{folder}/" in (root / ".gitignore").read_text("utf-8").split()
    assert f"path: {folder}/" in (root / ".github" / "workflows" / "ci.yml").read_text("utf-8")


def test_updating_writes_only_what_differs_and_only_at_home(goldens: Goldens) -> None:
    picture = draw("cube_in_thin_lines")
    keep(goldens, picture)
    file = goldens.folder / "picture.png"
    before = file.read_bytes()
    updating = dataclasses.replace(goldens, update=True)
    updating.check(picture, "picture")
    assert file.read_bytes() == before
    if goldens.driver == HOME:
        with pytest.raises(AssertionError, match=r"^wrote .*picture\.png: picture\.png differs .*--update-goldens\.$"):
            updating.check(picture[::-1], "picture")
        goldens.check(picture[::-1], "picture")
    else:
        with pytest.raises(AssertionError, match=r"^goldens are written by llvmpipe, Mesa 22 only, this is .* 25"):
            updating.check(picture[::-1], "picture")
        assert file.read_bytes() == before


def test_the_driver_is_known_by_its_name_and_its_major_version(device: GpuDevice) -> None:
    for driver, expected in {
        "Mesa 22.3.6 (LLVM 15.0.6)": HOME,
        "Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)": ELSEWHERE,
    }.items():
        lavapipe = dataclasses.replace(device.adapter, name="llvmpipe (LLVM 15.0.6, 256 bits)", driver=driver)
        assert driver_of(lavapipe) == expected
    assert (FOLDER / "driver.txt").read_text().strip() == HOME
