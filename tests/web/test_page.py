"""`save_page`: what the file holds, and what is refused before it is written."""

import gzip
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError, SizeWarning
from gpu_xform.web import page as web_page
from gpu_xform.web import poster
from gpu_xform.web.mesh_data import GRID_STEPS
from gpu_xform.web.short_program import make_program
from tests.web.test_arrays import decode

CUBE = gx.samples.cube()


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("pages") / "cube.html"
    gx.save_page(CUBE, path, title='A "cube" & <more>', size=(64, 48))
    return path.read_text("utf-8")


def test_a_page_needs_no_other_file(page: str) -> None:
    assert not re.search(r"""(?:src|href)\s*=\s*(?!["']?data:)""", page)
    assert "http" not in re.sub(r'id="(?:program|scene)">[^<]*<', "", page)


def test_a_page_has_its_title_and_a_poster_that_needs_no_script(page: str) -> None:
    title = "A &quot;cube&quot; &amp; &lt;more&gt;"
    assert f"<title>{title}</title>" in page
    assert re.search(rf'<img id="poster" alt="{title}" src="data:image/(webp|png);base64,[^"]+">', page)


def test_a_page_without_models_is_40_kb_and_the_models_add_little(page: str, tmp_path: Path) -> None:
    rest = re.sub(r'(id="scene">|;base64,)[^<"]*', r"\1", page)
    assert len(rest) + 4 * -(-poster.MAX_BYTES // 3) <= 40 << 10
    ring = gx.samples.torus(60, 40)
    gx.save_page(ring, tmp_path / "ring.html", size=(32, 32))
    scene = (tmp_path / "ring.html").read_text("utf-8").split('id="scene">')[1].split("<")[0]
    grid = np.rint(ring.positions * GRID_STEPS).astype(np.int32)
    plain = len(gzip.compress(grid.tobytes())) + len(gzip.compress(ring.indices.astype(np.uint16).tobytes()))
    assert len(scene) <= 1.1 * plain


def test_a_page_is_called_as_its_model_is(tmp_path: Path) -> None:
    gx.save_mesh(CUBE, tmp_path / "brick.obj")
    gx.save_page(str(tmp_path / "brick.obj"), tmp_path / "page.htm", size=(32, 32))
    assert "<title>brick</title>" in (tmp_path / "page.htm").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"path": "a.png"}, ArgumentError, "path must end in .html or .htm, got 'a.png'"),
        ({"path": 3}, ArgumentTypeError, "path must be a path, got int"),
        ({"title": 5}, ArgumentTypeError, "title must be a text, got int"),
        ({"fps": 5}, ArgumentError, "n_frames, duration and fps go with frames"),
        ({"labels": "indices"}, ArgumentError, "labels cannot go into a page"),
        ({"scalars": "z", "colorbar": True}, ArgumentError, "colorbar cannot go into a page"),
        ({"frames": [CUBE, gx.samples.house()]}, ArgumentError, "frames must move the models by matrices in a page"),
        (
            {"frames": [np.eye(4)], "section": ((0, 0, 0), (1, 0, 0))},
            ArgumentError,
            "section cannot go into a page with",
        ),
        ({"frames": [np.eye(4)], "edges": "intersection"}, ArgumentError, "cannot go into a page with frames"),
        ({"size": 7}, ArgumentError, "size must be"),
        ({"colour": "red"}, ArgumentTypeError, "did you mean 'color'"),
        ({"models": gx.Mesh(np.empty((0, 3)))}, MeshError, "model must have edges to draw"),
    ],
)
def test_what_a_page_cannot_show_is_refused_and_nothing_is_written(
    arguments: dict[str, Any], error: type[Exception], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given: dict[str, Any] = {"models": CUBE, "path": "page.html"} | arguments
    models, path = given.pop("models"), given.pop("path")
    with pytest.raises(error, match=re.escape(message)):
        gx.save_page(models, path, **given)
    assert not list(tmp_path.iterdir())


def test_an_animation_brings_its_own_frames_and_name(tmp_path: Path) -> None:
    gx.save_mesh(CUBE, tmp_path / "brick.obj")
    animation = gx.turntable(tmp_path / "brick.obj", 7, fps=5, size=(32, 24), color="red")
    gx.save_page(animation, tmp_path / "live.html")
    text = (tmp_path / "live.html").read_text("utf-8")
    scene, arrays = decode(text.split('id="scene">')[1].split("<")[0], make_program().names.shared)
    assert (scene["nFrames"], scene["fps"]) == (7, 5)
    assert arrays[scene["layers"][0]["matrices"]].shape == (7, 16)
    assert scene["layers"][0]["colors"] == {"kind": "one", "color": [1, 0, 0, 1]}
    assert "<title>brick</title>" in text
    with pytest.raises(ArgumentError, match=r"^color cannot go with an Animation, which has its own$"):
        gx.save_page(animation, tmp_path / "live.html", color="blue")


def test_a_page_of_many_edges_says_how_large_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web_page, "MANY_EDGES", 11)
    with pytest.warns(SizeWarning, match=r"^the page holds 12 edges, and is 0\.\d MB large: max_edges \(--max-edges\)"):
        gx.save_page(CUBE, tmp_path / "cube.html", size=(32, 32))
    gx.save_page(gx.samples.torus(9, 9), tmp_path / "ring.html", size=(32, 32), max_edges=100)
