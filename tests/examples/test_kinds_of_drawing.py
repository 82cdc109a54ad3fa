"""Seven models in three styles: the solids are closed, and each picture shows its model in its style."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx

PATH = Path(__file__).parents[2] / "examples" / "kinds_of_drawing.py"


@pytest.fixture(scope="module")
def work() -> Any:
    spec = importlib.util.spec_from_file_location("kinds_of_drawing", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_solids_are_closed_and_face_outwards(work: Any) -> None:
    wheel, hexagon = work.gear(), work.prism(work.circle(2, 6), 1, 4)
    for solid in (wheel, hexagon, work.tube(work.circle(3, 40), 1, 0, 2)):
        assert solid.to_trimesh().is_watertight
    assert hexagon.to_trimesh().volume == pytest.approx(3 * 6 * np.sqrt(3))
    assert work.scan().n_faces == 2 * 707**2


def test_every_picture_is_there(work: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scan = work.scan
    monkeypatch.setattr(work, "scan", lambda: scan(20))
    for style in (work.DASHED, work.SHADED):
        monkeypatch.setitem(style, "size", (90, 70))
    work.main(tmp_path)
    pictures = {path.stem: np.asarray(Image.open(path).convert("L")) for path in tmp_path.iterdir()}
    names = {"cube", "bracket", "gear", "teapot", "scan", "assembly"}
    expected = {f"{name}-{kind}" for name in names for kind in ("thumbnail", "dashed", "shaded")}
    assert set(pictures) == expected | {"cloud", "cloud-thumbnail"}
    for name in names - {"scan"}:
        dark = {kind: (pictures[f"{name}-{kind}"] < 250).mean() for kind in ("dashed", "shaded")}
        assert 0.02 < dark["dashed"] < 0.8 * dark["shaded"], name  # lines alone, and whole faces


def test_a_bracket_has_the_size_of_its_profile(work: Any) -> None:
    angle, boss = work.bracket()
    points = gx.transform_points(angle.model.positions, angle.transform)
    assert np.allclose([points.min(axis=0), points.max(axis=0)], [[0, -20, 0], [40, 20, 40]])
    assert gx.transform_points(boss.model.positions, boss.transform)[:, 2].min() == 6
