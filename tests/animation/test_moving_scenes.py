"""Scenes in motion: a dict of matrices per frame, or a matrix for all nodes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Animation, Camera, Mesh, Scene, animate, render, samples, turntable
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.formats import obj
from tests.support.spies import record_uploads

SIZE = (96, 64)
CAMERA = Camera.look_at((1, 4, 14), (0, 3, 0))
ARM = samples.robot_arm()


def bent(k: float) -> dict[str, Any]:
    return {
        "upper arm": ARM["upper arm"].transform @ gx.rotate_z(0.2 * k),
        "hand": ARM["hand"].transform @ gx.rotate_z(-0.5 * k),
    }


@pytest.mark.parametrize("computed", [False, True])
def test_a_dict_moves_the_nodes_that_it_names(computed: bool) -> None:
    if computed:
        animation = animate(ARM, bent, n_frames=4, size=SIZE, camera=CAMERA, color="navy")
    else:
        animation = animate(ARM, [bent(k) for k in range(4)], size=SIZE, camera=CAMERA, color="navy")
    frames = [frame.tobytes() for frame in animation]
    for k, frame in enumerate(frames):
        assert frame == render(ARM.posed(bent(k)), size=SIZE, camera=CAMERA, color="navy").tobytes()
    assert len(set(frames)) == 4


def test_a_matrix_moves_the_scene_after_its_transform() -> None:
    placed, moves = gx.scale(1, 0.5, 1), [gx.rotate_y(0.3 * k) for k in range(3)]
    animation = animate(ARM, moves, size=SIZE, camera=CAMERA, transform=placed)
    for k, move in enumerate(moves):
        assert animation.frame(k).tobytes() == render(ARM, transform=move @ placed, size=SIZE, camera=CAMERA).tobytes()
    posed = animate(ARM, [bent(2)], size=SIZE, camera=CAMERA, transform=placed).frame(0)
    assert posed.tobytes() == render(ARM.posed(bent(2)), transform=placed, size=SIZE, camera=CAMERA).tobytes()


def test_another_scene_may_take_its_place() -> None:
    other = Scene()
    other.add(samples.house(), transform=gx.translate(0, 2, 0))
    placed = gx.rotate_y(0.4)
    frames = [frame.tobytes() for frame in animate(ARM, [np.eye(4), other], size=SIZE, camera=CAMERA, transform=placed)]
    assert frames == [render(scene, transform=placed, size=SIZE, camera=CAMERA).tobytes() for scene in (ARM, other)]


def points_of(scene: Scene) -> Any:
    return np.concatenate(
        [shown.model.transformed(scene.world(node)).positions for node in scene for shown in node.models]
    )


def in_picture(camera: Camera, points: Any) -> Any:
    clip = np.column_stack([points, np.ones(len(points))]) @ camera.clip_from_world(SIZE[0] / SIZE[1]).T
    return clip[:, :2] / clip[:, 3:]


def test_one_camera_holds_every_pose() -> None:
    poses = [{**bent(k), "base": gx.translate(2 * k, 0, 0)} for k in range(8)]
    animation = animate(ARM, poses, size=SIZE)
    seen = [in_picture(animation.camera, points_of(ARM.posed(pose))) for pose in poses]
    assert 0.85 < np.abs(seen).max() < 0.9001  # of a margin of a twentieth on either side
    assert np.abs(in_picture(Camera.fit(points_of(ARM)), points_of(ARM.posed(poses[7])))).max() > 1.0


def test_a_scene_rotates_about_its_centre() -> None:
    animation = turntable(ARM, 4, size=SIZE, camera=CAMERA, transform=gx.translate(1, 0, 0))
    points = points_of(ARM) + np.array([1, 0, 0])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    for k in range(4):
        turn = gx.rotate((0, 1, 0), 90 * k, point=middle, degrees=True) @ gx.translate(1, 0, 0)
        expected = render(ARM, transform=turn, size=SIZE, camera=CAMERA)
        assert gx.compare_images(animation.frame(k), expected).n_pixels <= 2


def test_a_file_in_a_scene_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "house.obj"
    gx.save_mesh(samples.house(), path)
    reads: list[bytes] = []
    read = obj.read

    def spy(data: bytes, **options: Any) -> Mesh:
        reads.append(data)
        return read(data, **options)

    monkeypatch.setattr(obj, "read", spy)
    scene = Scene()
    scene.add(path, name="a")
    scene.add(str(path), name="b", transform=gx.translate(3, 0, 0), color="red")
    animation = animate(scene, lambda k: {"a": gx.translate(0, k, 0)}, n_frames=5, size=SIZE)
    path.unlink()
    assert len({frame.tobytes() for frame in animation}) == 5
    assert len(reads) == 1
    assert scene["a"].models[0].model == path


def test_a_model_is_uploaded_once_for_all_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    ball = samples.icosphere(3)
    scene = Scene()
    for i in range(3):
        scene.add(ball, name=f"ball {i}", transform=gx.translate(3 * i, 0, 0), hidden="remove")
    animation = animate(
        scene,
        lambda k: {"ball 1": gx.translate(3, 0.1 * k, 0)},
        n_frames=6,
        size=SIZE,
        camera={"direction": (0, 0, -1)},
    )
    uploads = record_uploads(monkeypatch)
    list(animation)
    first = len(uploads)
    assert [size > 1000 for size in uploads].count(True) == 3  # points, edges, triangles
    list(animation)
    assert max(uploads[first:]) < 1000


def test_what_is_done_to_the_scene_later_changes_no_frame() -> None:
    scene = samples.robot_arm()
    animation = animate(scene, bent, n_frames=2, size=SIZE, camera=CAMERA)
    before = animation.frame(1).tobytes()
    scene["base"].transform = gx.scale(0.1)
    scene.remove("hand")
    assert animation.frame(1).tobytes() == before


def frames_of(model: Any, frames: Any, **options: Any) -> list[Any]:
    animation: Animation = animate(model, frames, size=SIZE, camera=CAMERA, **options)
    return list(animation)


@pytest.mark.parametrize(
    ("model", "frames", "message"),
    [
        (ARM, [{}, {"elbow": np.eye(4)}], "frame 1: poses must name nodes of this scene, got 'elbow'"),
        (ARM, [{}, {"hand": np.eye(3)}], r"frames\[1\]\['hand'\] must have shape \(4, 4\), got \(3, 3\)"),
        (samples.house(), [{"hand": np.eye(4)}], "frame 0: model must be a Scene if frames move its"),
        (Scene(), [{}], "models must hold at least one model, got none"),
        (ARM, ARM, "frames must be matrices, one per frame, or a function that returns them, got Scene"),
    ],
)
def test_what_moves_no_scene_is_refused(model: Any, frames: Any, message: str) -> None:
    with pytest.raises((ArgumentError, ArgumentTypeError), match=f"^{message}"):
        frames_of(model, frames)


def test_a_wrong_matrix_of_a_function_is_named_with_its_frame() -> None:
    with pytest.raises(ArgumentError, match=r"^frames\(1\)\['hand'\] must be finite, got nan"):
        frames_of(ARM, lambda k: {"hand": np.diag([1, 1, np.nan if k else 1, 1])}, n_frames=2)
