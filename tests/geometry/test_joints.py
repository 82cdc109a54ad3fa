"""Joints of scenes, which numbers move: against rotations of SciPy, in double precision."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import gpu_xform as gx
from gpu_xform.errors import ArgumentError
from gpu_xform.geometry.joints import Joint, Mimic, resolve_mimics
from gpu_xform.geometry.scene import Scene
from tests.support.cost import within_cpu_s

AXIS = np.array([0.0, 0.6, 0.8])
ORIGIN = gx.translate(1, 2, 3) @ gx.rotate_x(0.3)


def make_scene(*others: Joint) -> Scene:
    joints = (
        Joint("turn", "revolute", "arm", ORIGIN, AXIS, -1.0, 2.0),
        Joint("slide", "prismatic", "hand", np.eye(4), AXIS, 0.0, 0.5),
        Joint("weld", "fixed", "tool", np.eye(4), AXIS),
    )
    scene = Scene(joints=[*joints, *others])
    scene.add(gx.samples.cube(), name="arm", transform=ORIGIN)
    scene.add(name="hand", parent="arm")
    scene.add(name="tool", parent="hand")
    return scene


@given(st.floats(-1.0, 2.0), st.floats(0.0, 0.5))
def test_a_number_turns_or_moves_a_node(angle: float, length: float) -> None:
    posed = make_scene().posed({"turn": angle, "slide": length})
    turned = np.eye(4)
    turned[:3, :3] = Rotation.from_rotvec(angle * AXIS).as_matrix()
    moved = np.eye(4)
    moved[:3, 3] = length * AXIS
    np.testing.assert_allclose(posed.world("tool"), ORIGIN @ turned @ moved, atol=1e-14)


def test_rows_of_numbers_give_stacks_of_matrices() -> None:
    scene = make_scene()
    angles = np.linspace(-1, 2, 5)
    stack = scene.posed({"turn": angles}).world("tool")
    assert stack.shape == (5, 4, 4)
    for matrix, angle in zip(stack, angles, strict=True):
        np.testing.assert_array_equal(matrix, scene.posed({"turn": float(angle)}).world("tool"))


def test_other_joints_stay_where_they_are() -> None:
    scene = make_scene().posed({"slide": 0.5}).posed({"turn": 0.25})
    np.testing.assert_array_equal(scene["hand"].transform[:3, 3], 0.5 * AXIS)
    assert [*scene.joints] == ["turn", "slide", "weld"]


def test_chains_of_followers_are_resolved() -> None:
    a = Joint("a", "continuous", "arm", np.eye(4), AXIS)
    b = Joint("b", "continuous", "b", np.eye(4), AXIS, mimic=Mimic("a", 2.0, 0.5))
    c = Joint("c", "prismatic", "c", np.eye(4), AXIS, mimic=Mimic("b", -3.0, 0.25))
    d = Joint("d", "revolute", "d", np.eye(4), AXIS, -0.1, 0.1, Mimic("c", 10.0, 1.0))
    scene = Scene(joints=[d, c, b, a])
    for name in ("arm", "b", "c", "d"):
        scene.add(name=name)
    posed = scene.posed({"a": 0.7})
    for joint, value in ((b, 2 * 0.7 + 0.5), (c, -3 * (2 * 0.7 + 0.5) + 0.25), (d, 10 * (-3 * 1.9 + 0.25) + 1)):
        np.testing.assert_allclose(posed[joint.node].transform, joint.matrix(value), atol=1e-13)
    with pytest.raises(ArgumentError, match=r"poses\['c'\] must not be given.*the joint follows 'a'"):
        scene.posed({"c": 0.1})


def test_each_joint_of_long_chains_is_followed_once() -> None:
    """Before, 8,000 joints took 9 s. They form a tree, in any order; the numbers are such that sums are exact."""
    random = np.random.default_rng(3)
    steps = random.choice([1, 1, 2], 6000).tolist()
    mimics = {k: Mimic(str(max(k - steps[k], 0)), 1.0, float(k)) for k in range(1, 6000)}
    order = random.permutation(6000).tolist()
    joints = {str(k): Joint(str(k), "continuous", str(k), np.eye(4), AXIS, mimic=mimics.get(k)) for k in order}
    for _ in within_cpu_s(0.5):
        found = resolve_mimics(joints)
    expected = {"0": 0.0}
    for k, mimic in mimics.items():
        expected[str(k)] = k + expected[mimic.joint]
    assert found == {name: Mimic("0", 1.0, expected[name]) for name in joints if name != "0"}
    assert list(found) == [name for name in joints if name != "0"]


def test_followers_of_themselves_or_of_nothing_are_refused() -> None:
    a = Joint("a", "continuous", "a", np.eye(4), AXIS, mimic=Mimic("b", 1.0, 0.0))
    b = Joint("b", "continuous", "b", np.eye(4), AXIS, mimic=Mimic("a", 1.0, 0.0))
    with pytest.raises(ArgumentError, match="joint 'a' follows itself"):
        resolve_mimics({"a": a, "b": b})
    with pytest.raises(ArgumentError, match="joint 'a' follows 'b', which is no joint that a number moves"):
        resolve_mimics({"a": a})


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ({"turn": 2.5}, r"the limits of the joint, which are -57\.3\.\.114\.6 degrees, got 2\.5, 143\.2 degrees"),
        ({"turn": [0.0, -1.5]}, r"poses\['turn'\] must lie in -1\.\.2, the limits of the joint, .* got -1\.5"),
        ({"turn": math.nan}, r"poses\['turn'\]"),
        (
            {"weld": 0.0},
            r"poses\['weld'\] must not be a number.*fixed joints take none; the node 'tool' takes a matrix",
        ),
        ({"arm": 0.5}, r"poses\['arm'\] must have shape"),
        ({"trun": 0.5}, "poses must name joints or nodes of this scene, got 'trun'; did you mean 'turn'"),
        ({"foo": 0.5}, "got 'foo'; joints that numbers move: 'turn'"),
        ({"turn": np.eye(4)}, "poses must name nodes of this scene, got 'turn'"),
    ],
)
def test_wrong_numbers_are_named(poses: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make_scene().posed(poses)  # type: ignore[arg-type]


def test_animations_take_numbers() -> None:
    scene, camera = make_scene(), gx.Camera.fit([[-6, -5, -4], [7, 8, 9]])
    poses: list[dict[str, Any]] = [{"turn": 0.5}, {"turn": 1.0, "hand": gx.translate(0, 1, 0)}]
    film = gx.animate(scene, poses, size=(32, 32), camera=camera)
    for frame, pose in zip(film, poses, strict=True):
        drawn = gx.render_array(scene.posed(pose), size=(32, 32), camera=camera)
        np.testing.assert_array_equal(np.asarray(frame), drawn)


def test_a_node_that_is_removed_takes_its_joint_along() -> None:
    scene = make_scene()
    scene.remove("hand")
    assert [*scene.joints] == ["turn"]
    assert repr(scene.joints["turn"]) == "<Joint 'turn': revolute 'arm', -1..2>"
