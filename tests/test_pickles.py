"""Pickles: what the package writes names no module of its inside, and what an earlier version wrote still loads."""

import inspect
import pickle
import pickletools
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from tests.support.old_pickles import PICKLES

PUBLIC = [name for name in gx.__all__ if not inspect.ismodule(getattr(gx, name))]


def mesh() -> gx.Mesh:
    return gx.Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 2.5)], [(0, 1, 2), (0, 2)])


def globals_in(data: bytes) -> set[str]:
    """Return the modules of the package that a pickle of protocol 0 names."""
    found = [argument for code, argument, _ in pickletools.genops(data) if code.name == "GLOBAL"]
    return {str(name) for name in found if str(name).startswith("gpu_xform")}


@pytest.mark.parametrize("protocol", [0, 4])
def test_an_old_pickle_of_a_mesh_loads(protocol: int) -> None:
    assert pickle.loads(PICKLES["mesh", protocol]) == mesh()  # noqa: S301


@pytest.mark.parametrize("protocol", [0, 4])
def test_an_old_pickle_of_a_scene_loads(protocol: int) -> None:
    scene = pickle.loads(PICKLES["scene", protocol])  # noqa: S301
    assert isinstance(scene, gx.Scene)
    assert [(node.name, node.parent) for node in scene] == [("base", None), ("arm", "base")]
    assert scene["base"].models == ((mesh(), {"color": "red"}),)
    assert np.array_equal(scene.world("arm"), gx.translate(1, 2, 3))


@pytest.mark.parametrize("protocol", [0, 4])
def test_an_old_pickle_of_a_layer_loads(protocol: int) -> None:
    layer = pickle.loads(PICKLES["layer", protocol])  # noqa: S301
    assert isinstance(layer, gx.Layer)
    assert layer.model == mesh()
    assert (layer.color, layer.line_width, layer.name) == ("red", 2.0, "part")


@pytest.mark.slow
@pytest.mark.parametrize("key", PICKLES, ids=lambda key: f"{key[0]} in protocol {key[1]}")
def test_an_old_pickle_loads_in_a_process_that_has_not_imported_the_package(key: tuple[str, int]) -> None:
    code = "import pickle, sys; print(type(pickle.loads(sys.stdin.buffer.read())).__name__)"
    done = subprocess.run([sys.executable, "-c", code], input=PICKLES[key], capture_output=True, check=True)
    assert done.stdout.decode().strip() == key[0].capitalize()


def test_every_public_class_and_function_is_of_the_package_itself() -> None:
    for name in PUBLIC:
        value = getattr(gx, name)
        assert value.__module__ == "gpu_xform", name
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            assert pickle.loads(pickle.dumps(value, protocol)) is value, name  # noqa: S301


def test_a_pickle_of_a_mesh_names_the_package_alone() -> None:
    data = pickle.dumps(mesh(), 0)
    assert globals_in(data) == {"gpu_xform Mesh"}
    assert pickle.loads(data) == mesh()  # noqa: S301


@pytest.mark.parametrize("value", [gx.ArgumentError("wrong"), gx.Layer(mesh(), color="red")], ids=repr)
def test_other_pickles_name_the_package_alone_as_well(value: Any) -> None:
    assert {name.split()[0] for name in globals_in(pickle.dumps(value, 0))} == {"gpu_xform"}


@pytest.mark.parametrize(
    "camera",
    [
        gx.Camera.look_at([1, 2, 3], [0, 0.5, 0], fov_y=30, near=0.1),
        gx.Camera.fit(mesh(), direction=[1, -1, -2], margin=0.1, orthographic=True),
        gx.Camera.window((-1, 2), (-3, 1)),
        gx.Camera.eye_on_z(5, (-1, 2), (-3, 1)),
    ],
    ids=repr,
)
def test_a_camera_is_the_same_after_a_pickle(camera: gx.Camera) -> None:
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        copied = pickle.loads(pickle.dumps(camera, protocol))  # noqa: S301
        assert np.array_equal(copied.clip_from_world(1.7), camera.clip_from_world(1.7))
        assert repr(copied) == repr(camera)


def test_frames_of_an_animation_are_the_same_after_a_pickle() -> None:
    animations = [
        gx.turntable(gx.samples.cube(), 6, size=(32, 32)),
        gx.turntable(gx.samples.cube(), 6, size=(32, 32))[2:4],
        gx.animate(gx.samples.cube(), [gx.identity(), gx.rotate_y(1)], size=(32, 32)),
    ]
    for animation in animations:
        copied = pickle.loads(pickle.dumps(animation))  # noqa: S301
        assert len(copied) == len(animation)
        assert np.array_equal(np.asarray(copied[1]), np.asarray(animation[1]))


def test_what_is_on_a_device_says_why_it_is_not_pickled() -> None:
    device = gx.Device("host")
    for value in (device, gx.PointBuffer(np.ones((3, 3), np.float32), device=device)):
        with pytest.raises(gx.ArgumentTypeError, match="cannot be copied or pickled"):
            pickle.dumps(value)


def test_public_functions_show_their_signature_and_their_source() -> None:
    for name in PUBLIC:
        value = getattr(gx, name)
        if inspect.isfunction(value):
            assert inspect.signature(value).return_annotation is not inspect.Signature.empty
            assert f"def {name}(" in inspect.getsource(value)
