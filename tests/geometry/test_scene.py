import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import gpu_xform as gx
from gpu_xform import Mesh, Scene, inverse, rotate_x, rotate_y, rotate_z, samples, scale, translate
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from tests.support.cost import within_cpu_s
from tests.support.reference_transform import AFFINE, PROJECTIVE

CUBE, HOUSE = samples.cube(), samples.house()


def some_matrix(seed: int) -> Any:
    """Return a matrix of sixteen distinct entries."""
    return np.random.default_rng(seed).normal(size=(4, 4))


def family() -> Scene:
    """Return a > (b > (c, d), e), f, none of it added in that order."""
    scene = Scene()
    for seed, (name, parent) in enumerate([("a", None), ("f", None), ("b", "a"), ("e", "a"), ("c", "b"), ("d", "b")]):
        scene.add(name=name, parent=parent, transform=some_matrix(seed))
    return scene


def names(scene: Scene) -> str:
    return "".join(node.name for node in scene)


def test_nodes_are_found_counted_and_walked_depth_first() -> None:
    scene = family()
    assert names(scene) == "abcdef"
    assert len(scene) == 6
    assert "c" in scene
    assert scene["c"] in scene
    assert "g" not in scene
    assert family()["c"] not in scene
    assert [scene[name].parent for name in "abcdef"] == [None, "a", "b", "b", "a", None]
    assert (len(Scene()), list(Scene())) == (0, [])


def test_a_world_matrix_is_the_product_down_the_path() -> None:
    scene = family()
    a, b, c = (scene[name].transform for name in "abc")
    assert scene.world("c").dtype == np.float64
    assert np.array_equal(scene.world("c"), a @ b @ c)
    assert np.array_equal(scene.world(scene["f"]), scene["f"].transform)
    point = np.array([1.0, 2.0, 3.0, 1.0])
    assert np.allclose(scene.world("c") @ point, a @ (b @ (c @ point)))


@st.composite
def trees(draw: st.DrawFn) -> list[tuple[int, int]]:
    """Return for each node its parent, an earlier one or -1, and the seed of its matrix."""
    n = draw(st.integers(1, 12))
    return [(draw(st.integers(-1, i - 1)), draw(st.integers(0, 99))) for i in range(n)]


def naive_world(tree: list[tuple[int, int]], i: int) -> Any:
    parent, seed = tree[i]
    return some_matrix(seed) if parent < 0 else naive_world(tree, parent) @ some_matrix(seed)


@given(tree=trees(), changes=st.lists(st.tuples(st.integers(0, 11), st.integers(0, 99)), max_size=4))
def test_worlds_are_right_before_and_after_any_change(tree: list[tuple[int, int]], changes: Any) -> None:
    scene = Scene()
    for i, (parent, seed) in enumerate(tree):
        scene.add(CUBE, name=str(i), parent=None if parent < 0 else str(parent), transform=some_matrix(seed))
    for place, seed in [(0, tree[0][1]), *changes]:
        changed = place % len(tree)
        scene[str(changed)].transform = some_matrix(seed)
        tree[changed] = tree[changed][0], seed
        for i in range(len(tree)):
            assert np.array_equal(scene.world(str(i)), naive_world(tree, i))
        (layer,) = scene.layers()
        assert np.array_equal(layer.transform, [scene.world(node) for node in scene])


@pytest.mark.slow
@given(tree=trees(), moves=st.lists(st.tuples(st.integers(0, 11), st.integers(-1, 11)), max_size=6))
def test_moves_keep_a_tree(tree: list[tuple[int, int]], moves: list[tuple[int, int]]) -> None:
    scene = Scene()
    for i, (parent, _) in enumerate(tree):
        scene.add(name=str(i), parent=None if parent < 0 else str(parent))
    parents = [parent for parent, _ in tree]
    for moved, target in moves:
        moved, target = moved % len(tree), target % len(tree) if target >= 0 else -1
        above = target
        while above not in (-1, moved):
            above = parents[above]
        if above == moved:
            with pytest.raises(ArgumentError, match=f"parent must not be within '{moved}' itself, got '{target}'"):
                scene.move(str(moved), str(target))
        else:
            scene.move(str(moved), None if target < 0 else str(target))
            parents[moved] = target
        walked = [int(node.name) for node in scene]
        assert sorted(walked) == list(range(len(tree)))
        for node in scene:
            parent = parents[int(node.name)]
            assert node.parent == (None if parent < 0 else str(parent))
            assert parent < 0 or walked.index(parent) < walked.index(int(node.name))


def test_a_moved_node_takes_along_what_is_in_it_and_keeps_its_matrix() -> None:
    scene = family()
    b, d = scene["b"].transform, scene["d"].transform
    scene.move("b", "f")
    assert names(scene) == "aefbcd"
    assert np.array_equal(scene.world("d"), scene["f"].transform @ b @ d)
    scene.move(scene["b"], None)
    assert np.array_equal(scene.world("d"), b @ d)
    scene.move("b", scene["e"])
    assert names(scene) == "aebcdf"


def test_removing_takes_away_what_is_in_a_node() -> None:
    scene = family()
    scene.remove("b")
    assert names(scene) == "aef"
    scene.add(name="b", parent="f")
    assert names(scene) == "aefb"
    scene.remove(scene["f"])
    assert names(scene) == "ae"
    with pytest.raises(ArgumentError, match=r"^node must be a node of this scene, or its name, got 'f'$"):
        scene.remove("f")


def test_what_would_be_no_tree_is_refused() -> None:
    scene = family()
    for moved, parent in (("a", "a"), ("a", "d"), ("b", "c")):
        with pytest.raises(ArgumentError, match=f"^parent must not be within '{moved}' itself, got '{parent}'$"):
            scene.move(moved, parent)
    with pytest.raises(
        ArgumentError, match=r"^name must be new, got 'c', which is in 'b' and cannot have a second par"
    ):
        scene.add(name="c", parent="f")
    with pytest.raises(ArgumentError, match=r"^name must be new, got 'a', which is in the world"):
        scene.add(name="a")
    assert names(scene) == "abcdef"


@pytest.mark.parametrize("which", ["g", "", 3, None, ["a"], family()["a"]])
def test_unknown_nodes_are_refused(which: Any) -> None:
    scene = family()
    for act, argument in (
        (lambda: scene[which], "name"),
        (lambda: scene.world(which), "node"),
        (lambda: scene.move(which, "a"), "node"),
    ):
        with pytest.raises(ArgumentError, match=f"^{argument} must be a node of this scene, or its name, got "):
            act()
    with pytest.raises(ArgumentError, match=r"^poses must name nodes of this scene, got "):
        scene.posed({"a": np.eye(4), str(which): np.eye(4)})
    if which is not None:
        for act in (lambda: scene.move("a", which), lambda: scene.add(name="new", parent=which)):
            with pytest.raises(ArgumentError, match=r"^parent must be a node of this scene"):
                act()
    assert names(scene) == "abcdef"


def test_names_are_texts_with_a_default() -> None:
    scene = Scene()
    assert scene.add().name == "node 1"
    assert scene.add(name="node 3").name == "node 3"
    assert [scene.add().name, scene.add(parent="node 3").name] == ["node 4", "node 5"]
    scene.remove("node 1")
    assert scene.add().name == "node 6"
    with pytest.raises(ArgumentTypeError, match=r"^name must be a text, got 3$"):
        scene.add(name=3)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"^name must not be empty$"):
        scene.add(name="")
    assert len(scene) == 4


def test_a_transform_is_any_finite_matrix() -> None:
    scene = Scene()
    node = scene.add(name="a")
    assert np.array_equal(node.transform, np.eye(4))
    turn = Rotation.from_euler("xyz", [0.1, 0.2, 0.3])
    for given_, expected in (
        (AFFINE, AFFINE),
        (PROJECTIVE.tolist(), PROJECTIVE),
        (turn, np.block([[turn.as_matrix(), np.zeros((3, 1))], [0, 0, 0, 1]])),
    ):
        node.transform = given_
        assert node.transform.dtype == np.float64
        assert np.array_equal(node.transform, expected)
        assert np.array_equal(scene.add(transform=given_).transform, expected)
        assert np.array_equal(scene.posed({"a": given_}).world("a"), expected)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), r"must have shape \(4, 4\), got \(3, 3\); homogeneous"),
        (np.zeros((2, 4, 4)), r"must have shape \(4, 4\), got \(2, 4, 4\)"),
        (np.diag([1, 1, np.nan, 1]), r"must be finite, got nan at index \(2, 2\)"),
        ("turn", "must hold real numbers"),
    ],
)
def test_no_other_matrix_is_taken(matrix: Any, message: str) -> None:
    scene = family()
    before = scene["a"].transform
    with pytest.raises((ArgumentError, ArgumentTypeError), match=f"^transform {message}"):
        scene["a"].transform = matrix
    with pytest.raises((ArgumentError, ArgumentTypeError), match=f"^transform {message}"):
        scene.add(transform=matrix)
    if np.ndim(matrix) == 3:  # a stack, which poses may be
        return
    with pytest.raises((ArgumentError, ArgumentTypeError), match=rf"^poses\['a'\] {message}"):
        scene.posed({"a": matrix})
    assert scene["a"].transform is before
    assert len(scene) == 6


def test_a_transform_changes_by_assignment_alone() -> None:
    matrix = AFFINE.copy()
    scene = Scene()
    nodes = [scene.add(transform=matrix), scene.add(), family()["a"]]
    nodes[2].transform = matrix
    matrix[0, 0] = 99
    assert np.array_equal(scene.world(nodes[0]), AFFINE)
    for node in nodes:
        with pytest.raises(ValueError, match="read-only"):
            node.transform[0, 3] = 1
    world = scene.world("node 1")
    world[:] = 0
    assert np.array_equal(scene.world("node 1"), AFFINE)


def test_a_world_matrix_that_overflows_is_an_error_that_names_the_node() -> None:
    scene = Scene()
    scene.add(name="far", transform=scale(1e200))
    scene.add(CUBE, name="farther", parent="far", transform=scale(1e200))
    for act in (lambda: scene.world("farther"), scene.layers):
        with pytest.raises(ArgumentError, match=r"^the world matrix of 'farther' must stay within float64's range"):
            act()


def test_layers_hold_each_model_once_for_every_style() -> None:
    scene = Scene()
    matrices = [some_matrix(seed) for seed in range(6)]
    chosen = np.array([(0, 1)])
    scene.add(CUBE, transform=matrices[0])
    scene.add(HOUSE, name="houses", transform=matrices[1], color="red", line_width=2)
    scene.add(CUBE, parent="houses", transform=matrices[2])
    scene.add(CUBE, transform=matrices[3], color="red", edges=chosen)
    scene.add(HOUSE, transform=matrices[4], line_width=2.0, color="".join(["r", "ed"]))
    scene["houses"].show(CUBE, color="red", edges=chosen)
    scene.add(samples.cube(), transform=matrices[5])
    cubes, houses, red, other = scene.layers()
    assert [layer.node for layer in (cubes, houses, red, other)] == ["node 1", "houses", "houses", "node 6"]
    assert cubes.model is CUBE
    assert cubes.style == {}
    assert np.array_equal(cubes.transform, [matrices[0], matrices[1] @ matrices[2]])
    assert houses.model is HOUSE
    assert houses.style == {"color": "red", "line_width": 2}
    assert np.array_equal(houses.transform, [matrices[1], matrices[4]])
    assert red.model is CUBE
    assert red.style["edges"] is chosen
    assert np.array_equal(red.transform, [matrices[1], matrices[3]])
    assert other.model == CUBE
    assert other.model is not CUBE
    assert np.array_equal(other.transform, matrices[5:])
    assert family().layers() == []


def test_styles_that_differ_anywhere_are_two() -> None:
    scene = Scene()
    for style in ({}, {"color": "red"}, {"color": "blue"}, {"line_width": 2}, {"edges": [(0, 1)]}, {"edges": [(0, 2)]}):
        scene.add(CUBE, **style)
    assert [dict(layer.style) for layer in scene.layers()] == [dict(node.models[0].style) for node in scene]


def test_a_node_shows_any_number_of_models() -> None:
    node = Scene().add(CUBE, color="red")
    node.show(HOUSE)
    node.show("ball.obj", line_width=3)
    assert [shown.model for shown in node.models] == [CUBE, HOUSE, "ball.obj"]
    assert [shown.style for shown in node.models] == [{"color": "red"}, {}, {"line_width": 3}]
    with pytest.raises(ArgumentError, match=r"^model must be given where a style is, got color, alpha alone$"):
        Scene().add(color="red", alpha=0.5)
    with pytest.raises(ArgumentError, match=r"^transform must be that of a node: a model stands where its node is$"):
        node.show(HOUSE, transform=np.eye(4))
    assert len(node.models) == 3


def test_a_posed_scene_shares_models_and_nothing_else() -> None:
    scene = family()
    scene["c"].show(CUBE)
    new = some_matrix(77)
    posed = scene.posed({"b": new})
    assert names(posed) == "abcdef"
    assert np.array_equal(posed.world("c"), scene["a"].transform @ new @ scene["c"].transform)
    assert np.array_equal(scene.world("c"), naive_world([(-1, 0), (0, 2), (1, 4)], 2))
    assert posed["c"].models[0].model is CUBE
    posed.remove("e")
    posed.add(name="g")
    posed["c"].show(HOUSE)
    posed["a"].transform = np.eye(4)
    posed.move("b", None)
    assert names(scene) == "abcdef"
    assert len(scene["c"].models) == 1
    assert np.array_equal(scene["a"].transform, some_matrix(0))


def test_poses_are_a_mapping() -> None:
    with pytest.raises(ArgumentTypeError, match=r"^poses must map names to matrices, got ndarray$"):
        family().posed(np.eye(4))  # type: ignore[arg-type]


def test_the_text_of_a_scene_is_its_tree() -> None:
    scene = family()
    scene["c"].show(CUBE)
    scene["c"].show(Mesh([(0, 0, 0)]))
    assert repr(scene) == (
        "<Scene: 6 nodes>\n  'a'\n    'b'\n      'c': <Mesh: 8 points, 6 faces>, <Mesh: 1 points, 0 faces>\n"
        "      'd'\n    'e'\n  'f'"
    )
    assert repr(scene["c"]) == "<Node 'c': <Mesh: 8 points, 6 faces>, <Mesh: 1 points, 0 faces>>"
    assert repr(scene["f"]) == "<Node 'f'>"


def chain_of(n: int) -> Scene:
    scene = Scene()
    parent = None
    for i in range(n):
        parent = scene.add(CUBE, name=str(i), parent=parent, transform=translate(1, 0, 2))
    return scene


@pytest.mark.slow
def test_a_chain_of_ten_thousand_is_no_hazard() -> None:
    for _ in within_cpu_s(5.0):
        scene = chain_of(10_000)
        assert np.array_equal(scene.world("9999"), translate(10_000, 0, 20_000))
        (layer,) = scene.layers()
        assert np.array_equal(layer.transform[:, 0, 3], np.arange(1, 10_001))
        posed = scene.posed({"0": scale(2)})
        assert np.array_equal(posed.world("9999"), scale(2) @ translate(9999, 0, 19_998))
        for same in (copy.deepcopy(posed), pickle.loads(pickle.dumps(posed))):  # noqa: S301 - our own bytes
            assert np.array_equal(same.world("9999"), posed.world("9999"))
        lines = repr(scene).splitlines()
        assert len(lines) == 41
        assert lines[-1] == "  ... and 9961 more"
        with pytest.raises(ArgumentError, match="parent must not be within '0' itself, got '9999'"):
            scene.move("0", "9999")
        scene.remove("1")
        assert len(scene) == 1


def test_the_robot_arm_carries_what_is_farther_out() -> None:
    arm = samples.robot_arm()
    assert [(node.name, node.parent) for node in arm] == [
        ("base", None),
        ("upper arm", "base"),
        ("forearm", "upper arm"),
        ("hand", "forearm"),
    ]
    joints = {"base": 0.0, "upper arm": 0.9, "forearm": 2.9, "hand": 4.5}
    for name, height in joints.items():
        assert np.array_equal(arm.world(name), translate(0, height, 0))
    shoulder, elbow, wrist = (rotate_z(0.3) @ rotate_y(0.2), rotate_x(-0.7), rotate_z(1.1))
    posed = arm.posed(
        {
            name: arm[name].transform @ turn
            for name, turn in (("upper arm", shoulder), ("forearm", elbow), ("hand", wrist))
        }
    )
    before, after = arm.world("hand"), posed.world("hand")
    expected = translate(0, 0.9, 0) @ shoulder @ translate(0, 2, 0) @ elbow @ translate(0, 1.6, 0) @ wrist
    assert np.allclose(after, expected, rtol=0, atol=1e-14)
    # Turning the upper arm alone turns all that it carries about the shoulder, as one.
    turned = arm.posed({"upper arm": arm["upper arm"].transform @ shoulder})
    about_shoulder = translate(0, 0.9, 0) @ shoulder @ translate(0, -0.9, 0)
    for name in ("upper arm", "forearm", "hand"):
        assert np.allclose(turned.world(name) @ inverse(arm.world(name)), about_shoulder, rtol=0, atol=1e-14)
    assert np.array_equal(turned.world("base"), np.eye(4))
    assert not np.allclose(before, after)


def test_the_parts_of_the_robot_arm_rotate_between_plates_and_touch_nothing() -> None:
    arm = samples.robot_arm()
    parts = [[shown.model for shown in arm[name].models] for name in ("base", "upper arm", "forearm", "hand")]
    assert [len(models) for models in parts] == [3, 1, 2, 1]
    for length, models in ((2.0, parts[1]), (1.6, parts[2])):
        for model in models:
            assert isinstance(model, Mesh)
            # Both ends are round, about this joint and the next.
            ends = np.where(model.positions[:, 1:2] > length / 2, (0.0, length, 0.0), 0.0)
            assert np.linalg.norm((model.positions - ends)[:, :2], axis=1) == pytest.approx(0.3)
    for outer, inner in ((parts[0][1:], parts[1]), (parts[2], parts[1]), (parts[2], parts[3])):
        depths = [np.abs(model.positions[:, 2]) for model in (*outer, *inner) if isinstance(model, Mesh)]
        assert min(depth.min() for depth in depths[:2]) > depths[2].max()


def test_a_matrix_between_two_nodes_goes_by_the_nearest_node_that_holds_both() -> None:
    arm = gx.samples.robot_arm()
    arm.add(name="camera", transform=gx.look_at((3, 4, 5), (0, 0, 0)))
    for source in arm:
        for target in arm:
            expected = gx.inverse(arm.world(target)) @ arm.world(source)
            assert np.abs(arm.transform_between(source, target.name) - expected).max() < 1e-12
    assert np.array_equal(arm.transform_between("hand", "hand"), np.eye(4))
    assert np.array_equal(arm.transform_between("hand", "forearm"), arm["hand"].transform)
    flat = arm.posed({"base": gx.scale(1, 1, 0)})
    assert np.array_equal(flat.transform_between("hand", "forearm"), arm["hand"].transform)
    with pytest.raises(gx.SingularMatrixError, match="from 'camera' to 'hand': m must have an inverse"):
        flat.transform_between("camera", "hand")
    with pytest.raises(ArgumentError, match="target must be a node of this scene"):
        arm.transform_between("hand", "foot")


def test_a_scene_posed_by_stacks_gives_stacks_and_draws_nothing(tmp_path: Path) -> None:
    arm = gx.samples.robot_arm()
    angles = np.linspace(-1, 1, 7)
    posed = arm.posed({"upper arm": arm["upper arm"].transform @ gx.rotate_z(angles), "hand": gx.rotate_x(angles)})
    assert posed.world("base").shape == (4, 4)
    for name in ("upper arm", "forearm", "hand"):
        worlds = posed.world(name)
        assert worlds.shape == (7, 4, 4)
        for angle, world in zip(angles, worlds, strict=True):
            one = arm.posed({"upper arm": arm["upper arm"].transform @ gx.rotate_z(angle), "hand": gx.rotate_x(angle)})
            assert np.abs(world - one.world(name)).max() < 1e-14
            between = posed.transform_between("base", name)[list(angles).index(angle)]
            assert np.abs(between - one.transform_between("base", name)).max() < 1e-14
    message = r"the matrix of 'upper arm' must have shape \(4, 4\) to be drawn or written, got \(7, 4, 4\)"
    for use in (posed.layers, lambda: gx.render(posed), lambda: gx.save_mesh(posed, tmp_path / "arm.glb")):
        with pytest.raises(ArgumentError, match=message):
            use()
    assert not list(tmp_path.iterdir())
    torn = arm.posed({"base": gx.rotate_z(angles), "hand": gx.rotate_x(angles[:3])})
    with pytest.raises(ArgumentError, match=r"the matrix of 'hand' must broadcast with a stack \(7,\), got \(3,\)"):
        torn.world("hand")


def bent_arm(time: float) -> dict[str, Any]:
    arm = samples.robot_arm()
    return {
        "upper arm": arm["upper arm"].transform @ rotate_z(0.4 * time),
        "hand": arm["hand"].transform @ rotate_x(-0.7 * time) @ translate(0.0, 0.1 * time, 0.0),
    }


def test_what_follows_a_node_stays_where_it_is_in_its_coordinates() -> None:
    arm = samples.robot_arm()
    in_hand = np.array([0.3, -0.2, 0.5, 1.0])
    for poses in (bent_arm, lambda time: arm.posed(bent_arm(time))):
        follow = arm.follow("hand", poses, start=0.5)
        np.testing.assert_allclose(follow(0.5), np.eye(4), atol=1e-14)
        at_start = arm.posed(bent_arm(0.5)).world("hand") @ in_hand
        for t in (0.0, 0.8, 3.0):
            expected = arm.posed(bent_arm(t)).world("hand") @ in_hand
            np.testing.assert_allclose(follow(t) @ at_start, expected, atol=1e-12)
    moved = arm.follow(arm["forearm"], bent_arm)(2.0)
    assert np.abs(moved - np.eye(4)).max() > 0.1


def test_what_cannot_be_followed_is_an_error() -> None:
    arm = samples.robot_arm()
    with pytest.raises(ArgumentError, match="node must be a node of this scene"):
        arm.follow("foot", bent_arm)
    with pytest.raises(
        ArgumentTypeError, match=r"^poses must be a SceneAnimation or a function of the time, got dict$"
    ):
        arm.follow("hand", bent_arm(0.0))  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="poses must name nodes of this scene, got 'foot'"):
        arm.follow("hand", lambda _: {"foot": np.eye(4)})
    with pytest.raises(gx.SingularMatrixError):
        arm.follow("hand", lambda _: {"hand": scale(1, 0, 1)})
