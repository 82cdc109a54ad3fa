"""The hair swings around the head, and its roots stay on it."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PATH = Path(__file__).parents[2] / "examples" / "hair.py"


def example() -> Any:
    spec = importlib.util.spec_from_file_location("hair", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_hair_falls_and_swings_with_the_head() -> None:
    work = example()
    hair, path = work.swing(12, 0.9)
    frames = np.asarray(path, np.float64).reshape(len(path), 12, work.N_POINTS, 3)
    assert len(path) == 19
    for time, frame in zip(path.times, frames, strict=True):
        matrix = work.world_from_head(time)
        assert frame[:, :2] == pytest.approx(hair.points[:, :2] @ matrix[:3, :3].T, abs=1e-6)
    assert np.linalg.norm(frames[:, :, 2:], axis=3).min() > work.RADIUS
    tips = frames[:, :, -1, 1]
    assert (tips[-1] < tips[0]).all()
    lengths = np.linalg.norm(np.diff(frames, axis=2), axis=3)
    assert (lengths / lengths[:1]).max() < 1.3
    colors = work.color(5)
    assert colors.shape == (5 * work.N_POINTS, 3)
    assert (colors[work.N_POINTS - 1] > colors[0]).all()
