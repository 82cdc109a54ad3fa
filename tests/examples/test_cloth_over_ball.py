"""The scarf falls onto the ball, not into it, and the README shows how it lies there."""

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
PATH = ROOT / "examples" / "cloth_over_ball.py"


def example() -> Any:
    spec = importlib.util.spec_from_file_location("cloth_over_ball", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_scarf_covers_the_ball_and_hangs_down_around_it() -> None:
    work = example()
    scarf = work.make_scarf(16)
    path = np.asarray(work.drop(scarf, 0.8), np.float64)
    distances = np.linalg.norm(path - work.CENTER, axis=2)
    assert distances[1:].min() > work.RADIUS + work.GAP - 1e-5
    end = path[-1].reshape(17, 17, 3)
    assert (distances[-1].reshape(17, 17)[7:10, 7:10] < work.RADIUS + work.GAP + 0.01).all()
    border = np.concatenate([end[0], end[-1], end[:, 0], end[:, -1]])
    assert (border[:, 1] < work.CENTER[1] + work.RADIUS / 2).all()
    assert np.ptp(path[0], axis=0)[1] == 0
    lengths = np.linalg.norm(end[1:] - end[:-1], axis=2)
    assert lengths.max() < 1.1 / 16


def silhouette(path: Path) -> Any:
    """Return which pixels lie between the leftmost and the rightmost line of their row."""
    with Image.open(path) as image:
        ink = np.asarray(image.convert("L")) < 200
    return np.logical_or.accumulate(ink, axis=1) & np.logical_or.accumulate(ink[:, ::-1], axis=1)[:, ::-1]


@pytest.mark.slow  # simulates 3,249 points
def test_the_readme_shows_its_last_frame(tmp_path: Path) -> None:
    ran = subprocess.run([sys.executable, PATH], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    picture, movie = (tmp_path / line.removeprefix("wrote ") for line in ran.stdout.splitlines())
    assert sorted((tmp_path / "demo").iterdir()) == [movie, picture]
    with Image.open(movie) as image:
        assert getattr(image, "n_frames", 1) == 27
    shown = ROOT / "docs" / "images" / picture.name
    assert shown.stat().st_size < 40_000
    drawn, kept = silhouette(picture), silhouette(shown)
    # Folds depend on the last bits of a device; where the scarf lies does not.
    assert np.count_nonzero(drawn & kept) > 0.9 * np.count_nonzero(drawn | kept)
    assert 0.2 < kept.mean() < 0.8
