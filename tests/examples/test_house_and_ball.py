"""The homework's animation: nothing slips, sinks or leaves its axis."""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import av
import numpy as np
import pytest

import gpu_xform as gx

PATH = Path(__file__).parents[2] / "examples" / "house_and_ball.py"


def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("house_and_ball", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


work: Any = example()
FRAMES = range(work.N_FRAMES)


def in_world(name: str, frame: float) -> Any:
    """Return all points of a node's model in a frame, by its world matrix."""
    scene = work.stage().posed(work.poses(frame))
    return scene[name].models[0].model.transformed(scene.world(name)).positions


def test_the_ball_rolls_its_radius_times_its_angle() -> None:
    radius = np.linalg.norm(in_world("ball", 0) - work.world_from_ball(0)[:3, 3], axis=1)
    assert radius == pytest.approx(work.RADIUS, rel=1e-12)
    angle = rolled = 0.0
    for frame in FRAMES:
        before, after = work.world_from_ball(frame), work.world_from_ball(frame + 1)
        turn = gx.decompose(after).rotation @ gx.decompose(before).rotation.T
        assert turn[:, 2] == pytest.approx([0, 0, 1])
        angle -= np.arctan2(turn[1, 0], turn[0, 0])
        rolled += after[0, 3] - before[0, 3]
        assert np.array_equal(after[1:3, 3], before[1:3, 3])
    assert angle > 2 * np.pi
    assert rolled == pytest.approx(work.RADIUS * angle, rel=1e-12)


def test_the_point_on_which_the_ball_stands_does_not_move() -> None:
    step = 1e-4
    for frame in FRAMES:
        matrix = work.world_from_ball(frame)
        motion = (work.world_from_ball(frame + step) - work.world_from_ball(frame - step)) / (2 * step)
        center = matrix[:3, 3]
        beneath = np.array([center[0], work.GROUND, center[2], 1.0])
        speed = np.linalg.norm(motion[:3, 3])
        assert np.linalg.norm(motion @ gx.inverse(matrix) @ beneath) < 1e-6 * speed
        above = beneath + np.array([0, 2 * work.RADIUS, 0, 0])
        assert np.linalg.norm(motion @ gx.inverse(matrix) @ above) == pytest.approx(2 * speed)


def test_nothing_sinks_into_the_ground_and_nothing_collides() -> None:
    lowest = []
    for frame in FRAMES:
        house, ball = in_world("house", frame), in_world("ball", frame)
        assert house[:, 1].min() == pytest.approx(work.GROUND)
        assert ball[:, 2].min() > house[:, 2].max()
        lowest.append(ball[:, 1].min())
    assert min(lowest) >= work.GROUND
    assert min(lowest) == pytest.approx(work.GROUND, abs=0.01 * work.RADIUS)
    assert np.ptp(in_world("ground", 0), axis=0) == pytest.approx([120, 0, 120], abs=1e-12)
    assert in_world("ground", 0)[:, 1] == pytest.approx(work.GROUND)


def test_the_house_rotates_once_about_its_own_axis() -> None:
    axis = np.array([[0, -1, 0, 1], [0, 1, 0, 1]]).T
    first = work.world_from_house(0)
    for frame in FRAMES:
        matrix = work.world_from_house(frame)
        assert np.array_equal(matrix @ axis, first @ axis)
        turn = gx.decompose(matrix).rotation @ gx.decompose(first).rotation.T
        assert turn == pytest.approx(gx.rotate_y(2 * np.pi * frame / work.N_FRAMES)[:3, :3], abs=1e-12)
    assert work.world_from_house(work.N_FRAMES) == pytest.approx(first)


def share_in_sight(points: Any) -> float:
    """Return which part of points lies within the window, as the lecture projects them from (0, 0, 100)."""
    x, y = (points[:, :2] / (1 - points[:, 2:] / 100)).T
    (left, right), (bottom, top) = work.XLIM, work.YLIM
    return float(np.mean((x > left) & (x < right) & (y > bottom) & (y < top)))


def test_the_ball_comes_into_sight_and_goes() -> None:
    shares = [share_in_sight(in_world("ball", frame)) for frame in [*FRAMES, work.N_FRAMES]]
    assert shares[0] == shares[-1] == 0
    assert sum(share == 1 for share in shares) > work.N_FRAMES / 2
    assert all(share_in_sight(in_world("house", frame)) == 1 for frame in FRAMES)


@pytest.mark.slow
def test_the_files_show_every_frame(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(work, "N_FRAMES", 40)
    work.main()
    written = [tmp_path / line.removeprefix("wrote ") for line in capsys.readouterr().out.splitlines()]
    assert sorted(written) == sorted((tmp_path / "demo").iterdir())
    assert [path.suffix for path in written] == [".html", ".mp4"]
    with av.open(str(written[1])) as movie:
        stream = movie.streams.video[0]
        assert stream.average_rate == work.FPS
        shown = [frame.to_ndarray(format="rgb24") for frame in movie.decode(stream)]
    assert len(shown) == work.N_FRAMES
    camera = gx.Camera.eye_on_z(100, work.XLIM, work.YLIM)
    for k in (1, 14, 37):
        picture = gx.render_array(work.stage().posed(work.poses(k)), camera=camera, size=(832, 480))[..., :3]
        before, own, after = (np.abs(shown[j] - picture.astype(np.float64)).mean() for j in (k - 1, k, k + 1))
        assert own < 0.5 * min(before, after)  # a video is lossy


def test_without_the_extra_the_page_is_there_and_it_is_said_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(work, "N_FRAMES", 2)
    monkeypatch.setitem(sys.modules, "av", None)
    work.main()
    first, second = capsys.readouterr().out.splitlines()
    page, movie = Path("demo/house_and_ball.html"), Path("demo/house_and_ball.mp4")
    assert first == f"wrote {page}"
    assert re.fullmatch(rf"left out {re.escape(str(movie))}: .* pip install 'gpu_xform\[video\]'", second)
    assert [path.name for path in Path("demo").iterdir()] == ["house_and_ball.html"]
