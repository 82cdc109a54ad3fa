"""Reports on many pictures: what each says of what matched, differed, was broken, new, or of no model."""

import json
import os
import re
import shutil
from base64 import b64decode
from html import unescape
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from gpu_xform import ArgumentError, Mesh, __version__, compare_images, samples, save_mesh, transform_file
from gpu_xform.cli import main

SIZE = ("--resolution", "96,64")
REFERENCE = ("--reference", "refs/{model}-{suffix}.png")
ODD_NAME = "-a <b> & 'c' [1] ü.obj"


def render(*typed: str) -> int:
    return main(["render", "models/**", *typed, *SIZE])


def references() -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path("refs").iterdir()}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of models with their references, after which one was changed, removed, broken, added, and moved."""
    folder = tmp_path_factory.mktemp("drawn")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("models/deep").mkdir(parents=True)
        house = samples.house()
        for name in ("same.obj", "same.ply", "changed.obj", "removed.obj", "broken.obj", f"deep/{ODD_NAME}"):
            save_mesh(house, f"models/{name}")
        assert render(*REFERENCE, "--update-references") == 0
        names = ["same-obj", "same-ply", "changed-obj", "removed-obj", "broken-obj", f"{Path(ODD_NAME).stem}-obj"]
        assert references().keys() == {f"{name}.png" for name in names}
        save_mesh(Mesh(house.positions, house.faces[2:]), "models/changed.obj")
        Path("models/removed.obj").unlink()
        Path("models/broken.obj").write_text("v 0 0\nnot a model")
        save_mesh(samples.cube(), "models/new.obj")
    return folder


@pytest.fixture
def _in_drawn(drawn: Path, working_folder: Path) -> None:
    shutil.copytree(drawn, working_folder, dirs_exist_ok=True)


STATUSES = {
    "models/broken.obj": ("failed", 2),
    "models/changed.obj": ("differs", 4),
    f"models/deep/{ODD_NAME}": ("matched", 0),
    "models/new.obj": ("no reference", 2),
    "models/same.obj": ("matched", 0),
    "models/same.ply": ("matched", 0),
}


@pytest.mark.usefixtures("_in_drawn")
def test_all_reports_of_one_run(capsys: pytest.CaptureFixture[str]) -> None:
    before = references()
    reports = [word for name in ("r.html", "r.json", "r.xml") for word in ("--report", f"made/here/{name}")]
    typed = ["-o", "out/{model}-{suffix}.png", "--reference-diff", "diff/{model}-{suffix}.png", *reports]
    assert render(*REFERENCE, *typed, "--reference-threshold", "9") == 2
    *lines, summary = capsys.readouterr().err.splitlines()
    assert lines[0] == "gpu-xform: warning: refs/removed-obj.png: no model has this reference"
    assert [line.split(": ")[2] for line in lines[1:]] == [
        "models/broken.obj",
        "models/changed.obj",
        "models/new.obj",
    ]
    assert summary == "gpu-xform: 6 pictures: 3 done, 2 failed, 1 not matching the reference"
    assert references() == before
    found = compare_images("out/changed-obj.png", "refs/changed-obj.png", threshold=9)
    check_json(json.loads(Path("made/here/r.json").read_bytes()), found)
    check_junit(ElementTree.parse("made/here/r.xml").getroot())  # noqa: S314 - our own file
    check_page(Path("made/here/r.html").read_text("utf-8"), found.image())


def check_json(report: dict[str, Any], found: Any) -> None:
    assert {(record["models"][0]): (record["status"], record["exit_code"]) for record in report["pictures"]} == STATUSES
    assert [record["models"][0] for record in report["pictures"]] == list(STATUSES)
    changed = report["pictures"][1]
    assert changed["different_pixels"] == found.n_pixels > 50
    assert changed["allowed_pixels"] == 16
    assert changed["largest_difference"] == found.largest
    assert changed["largest_at"] == list(found.largest_at)
    assert changed["mean_difference"] == pytest.approx(found.mean, abs=1e-6)
    assert (changed["picture"], changed["reference"], changed["difference"]) == (
        *("out/changed-obj.png", "refs/changed-obj.png", "diff/changed-obj.png"),
    )
    assert all(0 < record["time_s"] < 60 for record in report["pictures"])
    assert report["pictures"][0]["message"].startswith("line 1: ")
    assert report["pictures"][4]["message"] is None
    assert report["unused_references"] == ["refs/removed-obj.png"]
    assert report["counts"] == {"failed": 1, "differs": 1, "no reference": 1, "matched": 3}
    assert (report["exit_code"], report["reference_threshold"], report["version"]) == (2, 9, __version__)
    assert report["adapter"] != "none"


def check_junit(root: ElementTree.Element) -> None:
    (suite,) = root
    assert [suite.get(name) for name in ("tests", "failures", "errors", "skipped")] == ["7", "1", "2", "1"]
    cases = {f"{case.get('classname')}/{case.get('name')}": case for case in suite.iter("testcase")}
    kinds = {name: [child.tag for child in case] for name, case in cases.items()}
    kind_of = {"matched": [], "failed": ["error"], "no reference": ["error"], "differs": ["failure", "system-out"]}
    expected = {name: kind_of[status] for name, (status, _) in STATUSES.items()}
    assert kinds == {**expected, "refs/removed-obj.png": ["skipped"]}
    changed = cases["models/changed.obj"]
    assert changed.findtext("system-out") == "[[ATTACHMENT|diff/changed-obj.png]]"
    assert "difference: diff/changed-obj.png" in (changed.findtext("failure") or "")


def check_page(page: str, difference: Image.Image) -> None:
    assert "http" not in page.replace("http-equiv", "")
    titles = [unescape(title) for title in re.findall(r"<h2>(.*?) <span>", page)]
    assert titles == [
        *("Not drawn", "Different from the reference", "Without a reference", "As expected", "References of no model"),
    ]
    assert "3 of 6 need a look" in page
    (article,) = re.findall(r'<article class="differs">(.*?)</article>', page, re.DOTALL)
    assert re.findall("<figcaption>(.*?)</figcaption>", article) == ["expected", "actual", "difference"]
    pictures = [decode(data) for data in re.findall(r"data:image/png;base64,([^\"]+)", article)]
    assert np.array_equal(pictures[2], np.asarray(difference))
    with Image.open("refs/changed-obj.png") as expected, Image.open("out/changed-obj.png") as actual:
        assert np.array_equal(pictures[0], np.asarray(expected))
        assert np.array_equal(pictures[1], np.asarray(actual))
    broken = page.split('<article class="failed">')[1].split("</article>")[0]
    assert re.findall("<figcaption>(.*?)</figcaption>", broken) == ["expected"]
    assert f"models/deep/{ODD_NAME}" in unescape(page).replace("<wbr>", "")
    assert "<b>" not in page.replace("<b>1</b>", "").replace("<b>3</b>", "")
    assert page.count("<img ") == page.count("data:image") == 1 + 3 + 1 + 3


def decode(data: str) -> Any:
    with Image.open(BytesIO(b64decode(data))) as image:
        return np.asarray(image)


@pytest.mark.usefixtures("_in_drawn")
def test_references_are_updated_where_they_must_be_and_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    before = references()
    stamps = {path.name: path.stat().st_mtime_ns for path in Path("refs").iterdir()}
    assert render(*REFERENCE, "--update-references", "--report", "r.json", "--report", "r.html") == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].endswith("refs/removed-obj.png: no model has this reference")
    assert lines[1].startswith("gpu-xform: error: models/broken.obj: line 1")
    assert lines[2].startswith(
        "gpu-xform: refs/changed-obj.png: updated: the picture differs by more than 8 of 255 in "
    )
    assert lines[3:] == [
        "gpu-xform: refs/new-obj.png: added",
        "gpu-xform: 6 pictures: 5 done, 1 failed, 2 references written",
    ]
    after = references()
    assert {name for name in after if after[name] != before.get(name)} == {"changed-obj.png", "new-obj.png"}
    assert {path.name for path in Path("refs").iterdir() if path.stat().st_mtime_ns != stamps.get(path.name)} == {
        *("changed-obj.png", "new-obj.png"),
    }
    statuses = [record["status"] for record in json.loads(Path("r.json").read_bytes())["pictures"]]
    assert statuses == ["failed", "updated", "matched", "added", "matched", "matched"]
    page = Path("r.html").read_text("utf-8")
    assert "difference</figcaption>" in page.split('class="updated"')[1]
    assert "<b>1</b> reference updated</a>" in page
    Path("models/broken.obj").unlink()
    shutil.copy("models/new.obj", "models/newer.obj")
    assert render(*REFERENCE, "--update-references", "--report", "r.html") == 0
    assert '<h1 class="new">6 pictures, 1 new reference to look at</h1>' in Path("r.html").read_text("utf-8")
    assert render(*REFERENCE) == 0


@pytest.mark.usefixtures("_in_drawn")
def test_models_of_subfolders_that_are_left_out_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "models", *REFERENCE, "--update-references", *SIZE]) == 2
    assert capsys.readouterr().err.splitlines()[0] == "gpu-xform: models: 1 more below it, which models/** takes too"


@pytest.mark.usefixtures("_in_drawn")
def test_one_model_alone_is_compared_in_the_style_of_many_by_the_template(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "models/same.obj", *REFERENCE, *SIZE]) == 0
    assert main(["render", "models/same.obj", "--reference", "refs/same-obj.png", *SIZE]) == 4
    hint = "; if it was drawn by a path with {model}, type that path: one picture per model has another default style"
    assert hint in capsys.readouterr().err
    assert main(["render", "models/same.obj", "--reference", "refs/same-obj.png", "--fill", "red", *SIZE]) == 4
    assert "{model}" not in capsys.readouterr().err


@pytest.mark.usefixtures("_in_drawn")
def test_a_report_alone_draws_each_model(capsys: pytest.CaptureFixture[str]) -> None:
    before = set(Path().rglob("*"))
    assert main(["render", "models/same.obj", "models/broken.obj", "--report", "r.html", *SIZE]) == 2
    assert set(Path().rglob("*")) - before == {Path("r.html")}
    page = Path("r.html").read_text("utf-8")
    assert "1 of 2 needs a look" in page
    assert page.count("<img ") == 1
    assert capsys.readouterr().err.splitlines()[-1] == "gpu-xform: 2 pictures: 1 done, 1 failed"


@pytest.mark.usefixtures("_in_drawn")
def test_a_vector_picture_is_in_the_page_too() -> None:
    assert main(["render", "models/same.obj", "-o", "s.svg", "--report", "r.html", *SIZE]) == 0
    assert 'src="data:image/svg+xml,%3C%3Fxml' in Path("r.html").read_text(
        "utf-8"
    ) or 'src="data:image/svg+xml,%3Csvg' in (Path("r.html").read_text("utf-8"))


@pytest.mark.usefixtures("_in_drawn")
@pytest.mark.parametrize("kind", ["html", "pdf"])
def test_what_is_no_picture_to_embed_is_left_out_of_the_page(kind: str) -> None:
    assert main(["render", "models/same.obj", "-o", f"s.{kind}", "--report", "r.html", *SIZE]) == 0
    page = Path("r.html").read_text("utf-8")
    assert "no picture" in page
    assert "data:" not in page


@pytest.mark.usefixtures("_in_drawn")
def test_unused_references_are_told_of_a_whole_set_only(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "models/same.obj", *REFERENCE, *SIZE]) == 0
    assert capsys.readouterr().err == ""
    assert main(["render", "models/sam*.obj", *REFERENCE, *SIZE]) == 0
    warning = "gpu-xform: warning: refs/removed-obj.png: no model has this reference"  # others have models
    assert capsys.readouterr().err.splitlines() == [warning]
    # Beside models, other pictures are no references unless their names say so.
    for name in ("same.expected.png", "gone.expected.png", "wood.png"):
        shutil.copy("refs/same-obj.png", f"models/{name}")
    Path("models/same.ply").unlink()
    assert main(["render", "models/same*.obj", "--reference", "{folder}/{model}.expected.png", *SIZE]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines == ["gpu-xform: warning: models/gone.expected.png: no model has this reference"]


@pytest.mark.usefixtures("working_folder")
@pytest.mark.parametrize(
    ("template", "typed", "unused"),
    [
        ("refs/{folder}/{model}.png", "m/a", ["refs/m/a/gone.png"]),
        ("refs/{folder}/{model}.png", "m/a/**", ["refs/m/a/gone.png"]),
        ("refs/{folder}/{model}.png", "m/**", ["refs/m/a/gone.png", "refs/m/c/gone.png", "refs/m/gone.png"]),
        ("refs/{folder}/{model}.png", "m/a/*.off", ["refs/m/a/gone.png"]),
        ("refs/{model}.png", "m/a", ["refs/gone.png"]),
    ],
)
def test_references_of_folders_that_are_not_drawn_are_used(
    template: str, typed: str, unused: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("a/near", "a/b/deep", "c/far"):
        Path("m", name).parent.mkdir(parents=True, exist_ok=True)
        save_mesh(samples.cube(), f"m/{name}.off")
    options = ["--reference", template, "--resolution", "32,32"]
    assert main(["render", "m/**", *options, "--update-references"]) == 0
    for path in ("refs/gone.png", "refs/m/gone.png", "refs/m/a/gone.png", "refs/m/c/gone.png"):
        if Path(path).parent.is_dir():
            Path(path).touch()
    capsys.readouterr()
    assert main(["render", typed, *options]) == 0
    warned = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert warned == [f"gpu-xform: warning: {path}: no model has this reference" for path in unused]


@pytest.mark.usefixtures("_in_drawn")
@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["--update-references", "-o", "x.png"], "--update-references must come with --reference"),
        (["--report", "r.txt"], "--report: r.txt: the type must be one of html, json, xml, got txt"),
        (["--report", "-"], "--report: expected a file of type html, json, xml, not standard output"),
        (["--report", "r.json", "--report", "./r.json"], "r.json: another file of this run has that path"),
        (["--report", "r.json", "--sheet", "models/../r.json"], "the type must be one of png, svg, pdf"),
        (["--report", "models/new.obj/r.json"], "models/new.obj/r.json: Not a directory"),
        (["--report", "models/"], "expected the path of a file, got 'models/'"),
        (["--reference", "refs/{model}.png", "--update-references"], "refs/same.png: two pictures would be written"),
        (["--reference", "refs/one.png", "--update-references", "-o", "x/{model}-{suffix}.png"], "refs/one.png: two"),
        (["--reference", "refs/{model}.{suffix}", "--update-references"], "the type must be one of png, got obj"),
        (["--reference", "refs/{model}.jpg"], ".jpg: the type must be one of png, got jpg"),
        (
            ["--reference", "refs"],
            "refs: the type must be one of png, got none; refs/{model}.png is a picture per model",
        ),
        (["-o", "refs"], "htm, got none; refs/{model}.png is a picture per model in that folder"),
        (["-o", "drawn/"], "path of a file, got 'drawn/'; drawn/{model}.png is a file per model in that folder"),
        (["--sheet", "s.png", "-o", "all.png"], "--sheet must go with one picture per model"),
        (["--sheet", "s.png", "--paper", "A4"], "--paper cannot go with --sheet"),
    ],
)
def test_what_cannot_be_is_said_before_any_work(
    typed: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.stat().st_mtime_ns for path in Path().rglob("*")}
    assert render(*typed) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert {path: path.stat().st_mtime_ns for path in Path().rglob("*")} == before


@pytest.mark.usefixtures("_in_drawn")
def test_a_pointer_of_git_lfs_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("refs/same-obj.png", "models/changed.obj", "models/new.step"):
        Path(name).write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    models = ["models/same.obj", "models/changed.obj", "models/new.step"]
    reports = ["--report", "r.json", "--report", "r.html"]
    assert main(["render", *models, *REFERENCE, "--update-references", *reports, *SIZE]) == 2
    words = "a pointer of Git LFS, not the file itself, which git lfs pull fetches"
    assert capsys.readouterr().err.splitlines()[:-1] == [
        f"gpu-xform: error: models/same.obj: refs/same-obj.png: {words}",
        *(f"gpu-xform: error: {model}: {words}" for model in models[1:]),
    ]
    assert b"git-lfs" in Path("refs/same-obj.png").read_bytes()
    statuses = [record["status"] for record in json.loads(Path("r.json").read_bytes())["pictures"]]
    assert statuses == ["no reference", "failed", "failed"]
    assert "Not drawn" not in Path("r.html").read_text("utf-8").split('id="no-reference"')[1]
    shutil.copy("models/changed.obj", "image.png")
    assert main(["convolve", "image.png", "soft.png", "--gaussian", "1"]) == 2
    assert f"image.png: {words}" in capsys.readouterr().err
    shutil.copy("image.png", "faces.npy")
    assert main(["render", "models/same.ply", "-o", "x.png", "--face-colors", "faces.npy", *SIZE]) == 2
    assert f"faces.npy: {words}" in capsys.readouterr().err
    with pytest.raises(ArgumentError, match="source must hold points, got a pointer of Git LFS"):
        transform_file("models/changed.obj", "out.npy", np.eye(4))


@pytest.mark.usefixtures("_in_drawn")
@pytest.mark.skipif(os.name == "nt", reason="names are Unicode there")
def test_names_that_are_no_unicode() -> None:
    name = os.fsdecode(b"models/\xff\x1b[31m.obj")
    shutil.copy("models/same.obj", name)
    reports = [word for kind in ("html", "json", "xml") for word in ("--report", f"r.{kind}")]
    assert main(["render", name, *reports, *SIZE]) == 0
    ElementTree.parse("r.xml")  # noqa: S314 - our own file
    assert "\x1b" not in Path("r.html").read_text("utf-8")
    assert json.loads(Path("r.json").read_bytes())["pictures"][0]["models"] == [name]
