"""Animations of glTF nodes, against SciPy's interpolation."""

import io
import tracemalloc
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, interp1d
from scipy.spatial.transform import Rotation, Slerp

from gpu_xform import Scene, load_scene, samples
from gpu_xform.animation import animate
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError, MeshWarning
from tests.support.gltf_files import Builder

CUBE = samples.cube().to_trimesh()
TIMES = np.array([0.5, 1.0, 2.5, 4.0])
SAMPLES = np.array([0.0, 0.5, 0.7, 1.0, 1.9, 2.5, 3.3, 4.0, 9.0])
RNG = np.random.default_rng(7)
MOVES, SIZES = RNG.normal(size=(4, 3)), RNG.random((4, 3)) + 0.5
TURNS = Rotation.random(4, rng=RNG)


def animated(*channels: tuple[str, Any, str], **node: Any) -> Builder:
    """Return a cube in a node that channels of (property, values, interpolation) move."""
    builder = Builder()
    points = builder.array(CUBE.vertices)
    targets = [{"POSITION": builder.array(np.full((8, 3), k + 1.0))} for k in range(2)]
    builder.mesh(
        {"attributes": {"POSITION": points}, "indices": builder.array(CUBE.faces.ravel(), "<u2"), "targets": targets}
    )
    builder.node(name="cube", mesh=0, **node)
    samplers = [
        {"input": builder.array(TIMES), "output": builder.array(values), "interpolation": kind}
        for _, values, kind in channels
    ]
    builder.content["animations"] = [
        {
            "name": "dance",
            "samplers": samplers,
            "channels": [
                {"sampler": i, "target": {"node": 0, "path": path}} for i, (path, _, _) in enumerate(channels)
            ],
        }
    ]
    return builder


def scene_of(builder: Builder) -> Scene:
    return load_scene(io.BytesIO(builder.pack()), file_type="glb")


def transform_at(scene: Scene, time: float) -> Any:
    return scene.animations["dance"].at(time).transforms["cube"]


def test_linear_keyframes() -> None:
    scene = scene_of(
        animated(("translation", MOVES, "LINEAR"), ("rotation", TURNS.as_quat(), "LINEAR"), ("scale", SIZES, "LINEAR"))
    )
    assert list(scene.animations) == ["dance"]
    assert scene.animations["dance"].duration == 4.0
    for time in SAMPLES:
        t = np.clip(time, TIMES[0], TIMES[-1])
        expected = np.eye(4)
        expected[:3, :3] = Slerp(TIMES, TURNS)(t).as_matrix() * interp1d(TIMES, SIZES, axis=0)(t)
        expected[:3, 3] = interp1d(TIMES, MOVES, axis=0)(t)
        assert np.allclose(transform_at(scene, time), expected, atol=1e-6)


def test_steps() -> None:
    scene = scene_of(animated(("translation", MOVES, "STEP")))
    for time in SAMPLES:
        k = max(np.searchsorted(TIMES, time, side="right") - 1, 0)
        assert np.allclose(transform_at(scene, time)[:3, 3], MOVES[k], atol=1e-6)


def test_cubic_splines() -> None:
    tangents = RNG.normal(size=(4, 3))
    values = np.stack([tangents, MOVES, tangents], axis=1).reshape(-1, 3)
    scene = scene_of(animated(("translation", values, "CUBICSPLINE")))
    for time in SAMPLES:
        expected = CubicHermiteSpline(TIMES, MOVES, tangents)(np.clip(time, TIMES[0], TIMES[-1]))
        assert np.allclose(transform_at(scene, time)[:3, 3], expected, atol=1e-5)


def test_properties_without_a_channel_stay() -> None:
    turn = TURNS[1].as_quat().tolist()
    scene = scene_of(animated(("translation", MOVES, "STEP"), rotation=turn, scale=[1, 2, 3]))
    expected = TURNS[1].as_matrix() * (1, 2, 3)
    assert np.allclose(transform_at(scene, 1.0)[:3, :3], expected)
    assert np.allclose(scene["cube"].transform[:3, :3], expected)


def test_morph_weights_move() -> None:
    weights = RNG.random((4, 2))
    scene = scene_of(animated(("weights", weights.ravel(), "LINEAR")))
    for time in SAMPLES:
        poses = scene.animations["dance"].at(time)
        expected = interp1d(TIMES, weights, axis=0)(np.clip(time, TIMES[0], TIMES[-1]))
        assert np.allclose(poses.weights["cube"], expected, atol=1e-6)
        (layer,) = scene.posed(*poses).layers()
        assert np.allclose(layer.model.positions, CUBE.vertices + expected @ (1, 2), atol=1e-5)


def test_animate_plays_what_the_file_holds() -> None:
    scene = scene_of(animated(("translation", MOVES, "LINEAR")))
    animation = animate(scene, scene.animations["dance"], fps=10, size=(32, 24))
    assert len(animation) == 41
    assert animation.fps == 10
    for k in (0, 17, 40):
        moved = scene.posed({"cube": transform_at(scene, k / 10)})
        other = animate(moved, [np.eye(4)], size=(32, 24), camera=animation.camera)
        assert animation.frame(k).tobytes() == other.frame(0).tobytes()
    with pytest.raises(ArgumentTypeError, match="model must be a Scene"):
        animate(samples.cube(), scene.animations["dance"]).frame(0)
    with pytest.raises(ArgumentError, match="n_frames and duration go with a function"):
        animate(scene, scene.animations["dance"], n_frames=3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"path": "color"}, "it moves 'color', which is none of translation, rotation, scale, weights"),
        ({"path": "pointer", "extensions": {"KHR_animation_pointer": {}}}, "it moves 'pointer'"),
        ({"path": "scale"}, "must be of type VEC3, got \"'VEC4'\""),
    ],
)
def test_channels_that_cannot_be_read_are_named(change: dict[str, Any], message: str) -> None:
    builder = animated(("rotation", TURNS.as_quat(), "LINEAR"), ("translation", MOVES, "LINEAR"))
    builder.content["animations"][0]["channels"][0]["target"].update(change)
    with pytest.warns(MeshWarning, match="animation 'dance' misses its channel 0, which cannot be read: ") as caught:
        scene = scene_of(builder)
    assert message in str(caught[0].message)
    assert [channel.property for channel in scene.animations["dance"].channels] == ["translation"]


def test_keyframes_that_contradict_themselves_are_named() -> None:
    for values, kind, message in (
        (MOVES[:3], "LINEAR", "it has 3 values for 4 times"),
        (MOVES, "CUBICSPLINE", "it has 4 values for 4 times"),
        (MOVES, "WAVY", "its interpolation must be one of STEP, LINEAR, CUBICSPLINE, got 'WAVY'"),
        (MOVES * np.nan, "LINEAR", "its values must be finite"),
    ):
        with pytest.warns(MeshWarning, match=message):
            assert not scene_of(animated(("translation", values, kind))).animations
    builder = animated(("translation", MOVES, "LINEAR"))
    builder.content["animations"][0]["samplers"][0]["input"] = builder.array([0, 2, 1, 3])
    with pytest.warns(MeshWarning, match="its times must ascend"):
        scene_of(builder)
    matrix = np.eye(4).ravel().tolist()
    with pytest.warns(MeshWarning, match="node 0 has a matrix, not the property that moves"):
        scene_of(animated(("translation", MOVES, "LINEAR"), matrix=matrix))


def animated_nodes(n_nodes: int, n_times: int, n_samplers: int) -> bytes:
    """Return a file of nodes that the samplers of one animation move in turn, each with accessors of its own."""
    builder = Builder()
    builder.mesh({"attributes": {"POSITION": builder.array(CUBE.vertices)}, "mode": 0})
    builder.node(mesh=0)
    times, values = builder.array(np.arange(n_times)), builder.array(np.ones((n_times, 3)))
    accessors = builder.content["accessors"]
    samplers = []
    for _ in range(n_samplers):
        samplers.append({"input": len(accessors), "output": len(accessors) + 1})
        accessors += [accessors[times], accessors[values]]
    channels = [
        {"sampler": i % n_samplers, "target": {"node": builder.node(), "path": "scale"}} for i in range(n_nodes)
    ]
    builder.content["animations"] = [{"samplers": samplers, "channels": channels}]
    return builder.pack()


@pytest.mark.parametrize("isolated", [False, True])
def test_channels_share_the_keyframes_of_their_sampler(isolated: bool) -> None:
    scene = load_scene(io.BytesIO(animated_nodes(6, 9, 2)), file_type="glb", isolated=isolated)
    channels = scene.animations["animation 0"].channels
    assert [channel.node for channel in channels] == [f"node {i + 1}" for i in range(6)]
    for of_one in (channels[::2], channels[1::2]):
        assert {id(channel.times) for channel in of_one} == {id(of_one[0].times)}
        assert {id(channel.values) for channel in of_one} == {id(of_one[0].values)}
        assert np.array_equal(of_one[0].values, np.ones((9, 3)))
    assert channels[0].values is not channels[1].values


def test_keyframes_are_counted_before_they_are_read() -> None:
    data = animated_nodes(400, 40_000, 400)  # 512 MB
    tracemalloc.start()
    try:
        with pytest.raises(MeshError, match=r"the keyframes of its animations: expands to more than [\d,]+ numbers"):
            load_scene(io.BytesIO(data), file_type="glb")
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()
