"""URDF as a scene: against forward kinematics written out in double precision, with SciPy's rotations."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gpu_xform import FileLimits, Mesh, Scene, load_mesh, load_scene, save_mesh
from gpu_xform.cli import main
from gpu_xform.errors import MeshError, MeshWarning, MissingExtraError
from gpu_xform.formats import urdf
from gpu_xform.formats.urdf_files import ModelFinder
from tests.support.cost import within_cpu_s
from tests.support.urdf_files import ARM, TETRAHEDRON, TRIANGLE_DAE


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A robot in a package, with its meshes beside the folder of the URDF, and below it."""
    package = tmp_path / "arm_description"
    for folder in ("urdf/meshes", "meshes"):
        (package / folder).mkdir(parents=True)
        (package / folder / "tetra.stl").write_text(TETRAHEDRON, "utf-8")
    path = package / "urdf" / "arm.urdf"
    path.write_text(ARM, "utf-8")
    return path


def read(text: str) -> Scene:
    return load_scene(io.BytesIO(text.encode()), file_type="urdf")


def place(xyz: tuple[float, ...], rpy: tuple[float, ...] = (0, 0, 0)) -> Any:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    matrix[:3, 3] = xyz
    return matrix


def turn(axis: tuple[float, ...], angle: float) -> Any:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis)).as_matrix()
    return matrix


@pytest.mark.parametrize(("shoulder", "slide"), [(0.0, 0.0), (0.7, 0.3), (-1.5, 0.125)])
def test_forward_kinematics(robot: Path, shoulder: float, slide: float) -> None:
    posed = load_scene(robot).posed({"shoulder": shoulder, "slide": slide})
    upper = place((0.1, -0.2, 0.3), (0.4, -0.5, 0.6)) @ turn((0, 3, 4), shoulder)
    slider = upper @ place((0, 0, 0.5), (0, 0, 1.2)) @ place((0, 0, -slide))
    finger = slider @ place((0.2, 0, 0)) @ turn((1, 0, 0), -4 * slide + 0.25)
    tip = finger @ place((0, 0.1, 0)) @ turn((1, 0, 0), 0.5 * (-4 * slide + 0.25) - 0.1)
    for name, expected in (("upper", upper), ("slider", slider), ("finger", finger), ("tip", tip)):
        np.testing.assert_allclose(posed.world(name), expected, atol=1e-14, err_msg=name)
    np.testing.assert_allclose(posed.world("tool"), tip @ place((0, 0, 0.05)), atol=1e-14)


def test_as_it_is_read_every_joint_is_at_zero(robot: Path) -> None:
    scene = load_scene(robot)
    posed = scene.posed({"shoulder": 0.0, "slide": 0.0})
    for node in scene:
        np.testing.assert_allclose(scene.world(node.name), posed.world(node.name), atol=1e-15)
    assert {joint.name: joint.kind for joint in scene.joints.values()} == {
        "shoulder": "revolute",
        "slide": "prismatic",
        "finger": "continuous",
        "tip_joint": "revolute",
        "mount": "fixed",
    }
    np.testing.assert_allclose(scene.joints["shoulder"].axis, (0, 0.6, 0.8))


def test_links_show_shapes_and_files_in_their_colors(robot: Path) -> None:
    scene = load_scene(robot)
    assert [node.name for node in scene] == ["base", "upper", "tube", "slider", "finger", "tip", "tool"]
    box, tube, ball, finger, tip = (scene[name].models[0].model for name in ("base", "tube", "slider", "finger", "tip"))
    assert all(isinstance(each, Mesh) for each in (box, tube, ball, finger, tip))
    np.testing.assert_allclose(box.bounds, [(-0.2, -0.15, -0.05), (0.2, 0.15, 0.05)])
    np.testing.assert_allclose(tube.bounds[:, 2], (-0.25, 0.25))
    assert scene["tube"].parent == "upper"
    np.testing.assert_allclose(scene["tube"].transform, place((0, 0, 0.25)))
    np.testing.assert_allclose(np.linalg.norm(ball.positions, axis=1), 0.08)
    # Mirrored, and so turned back to face outwards.
    np.testing.assert_allclose(finger.bounds, [(0, -0.2, 0), (0.1, 0, 0.2)], atol=1e-7)
    np.testing.assert_allclose(tip.bounds, [(0, 0, 0), (0.1, 0.1, 0.2)], atol=1e-7)
    colors = [np.asarray(each.attributes.face["color"])[0].tolist() for each in (box, tube, ball)]
    assert colors == [[51, 102, 204, 255], [255, 0, 0, 128], [255, 255, 255, 255]]


def test_files_of_packages_are_found_beside_the_package_or_by_the_environment(
    robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = tmp_path / "elsewhere" / "robot.urdf"
    elsewhere.parent.mkdir()
    link = '<robot><link name="a"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'
    elsewhere.write_text(link.format("package://arm_description/meshes/tetra.stl"), "utf-8")
    assert load_mesh(elsewhere).n_faces == 2  # a folder beside one of those above
    moved = tmp_path / "ros" / "share"
    moved.mkdir(parents=True)
    robot.parents[1].rename(moved / "arm_description")
    missing = "left out: 'package://arm_description/meshes/tetra.stl', which was not found; ROS_PACKAGE_PATH says where"
    with pytest.warns(MeshWarning, match=missing):
        assert not load_scene(elsewhere)["a"].models
    for variable, place in (("ROS_PACKAGE_PATH", moved), ("AMENT_PREFIX_PATH", moved.parent)):
        monkeypatch.setenv(variable, f"/nowhere:{place}")
        assert load_mesh(elsewhere).n_faces == 2
        monkeypatch.delenv(variable)


def test_each_missing_file_counts_however_long_its_path(robot: Path) -> None:
    link = '<link name="{0}"><visual><geometry><mesh filename="package://{1}/{0}.stl"/></geometry></visual></link>'
    joint = '<joint name="{0}" type="fixed"><parent link="0"/><child link="{0}"/></joint>'
    links = "".join(link.format(k, "long_name/" * 20) for k in range(6))
    robot.write_text(f"<robot>{links}{''.join(map(joint.format, range(1, 6)))}</robot>", "utf-8")
    with pytest.warns(MeshWarning, match=r"left out: '\.\.\.\S*long_name//0\.stl', which .*, and 2 more; ROS"):
        load_scene(robot)


@pytest.mark.parametrize(
    "name", ["../../secret.stl", "/etc/hostname", "package://../secret.stl", "file:///etc/hostname"]
)
def test_files_outside_of_the_package_are_not_opened(robot: Path, name: str) -> None:
    (robot.parents[2] / "secret.stl").write_text(TETRAHEDRON, "utf-8")
    (robot.parents[1] / "package.xml").write_text("<package/>", "utf-8")
    text = f'<robot><link name="a"><visual><geometry><mesh filename="{name}"/></geometry></visual></link></robot>'
    robot.write_text(text, "utf-8")
    with pytest.warns(MeshWarning, match="which was not found"):
        load_scene(robot)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<robot", "<mujoco", "it is not XML|its root is <mujoco>"),
        ('<child link="tool"/>', '<child link="tip"/>', "link 'tip' has a parent already"),
        ('<child link="tool"/>', '<child link="too"/>', "the child must be a link, got 'too'"),
        (
            '<link name="tool"/>',
            '<link name="tool"/><link name="loose"/>',
            "one link must have no parent, got 'base', 'loose'",
        ),
        ('<link name="tool"/>', '<link name="tip"/>', "there are two links 'tip'"),
        ('type="prismatic"', 'type="screw"', "joint 'slide': the type must be one of revolute"),
        ('<axis xyz="0 3 4"/>', '<axis xyz="0 0 0"/>', "joint 'shoulder': the axis has no direction"),
        ('<axis xyz="0 3 4"/>', '<axis xyz="0 3"/>', "joint 'shoulder': xyz must be 3 numbers, got '0 3'"),
        ('<axis xyz="0 3 4"/>', '<axis xyz="0 nan 1"/>', "joint 'shoulder': xyz must be 3 numbers"),
        ('lower="0" upper="0.3"', 'lower="1" upper="0.3"', "the lower limit 1 is above the upper one, 0.3"),
        ('mimic joint="slide"', 'mimic joint="tip_joint"', "follows itself"),
        ('mimic joint="slide"', 'mimic joint="mount"', "follows 'mount', which is no joint that a number moves"),
        ('size="0.4 0.3 0.1"', 'size="0.4 0 0.1"', "link 'base': a box must have a size above 0, got 0"),
        ("meshes/tetra.stl", "arm.urdf", "of a type that cannot be read"),
    ],
)
def test_what_is_no_robot_is_named(robot: Path, old: str, new: str, message: str) -> None:
    robot.write_text(
        ARM.replace(old, new, 1).replace("</robot>", "</mujoco>" if "mujoco" in new else "</robot>"), "utf-8"
    )
    if "type that cannot" in message:
        with pytest.warns(MeshWarning, match=message):
            load_scene(robot)
        return
    with pytest.raises(MeshError, match=message):
        load_scene(robot)


def test_a_namespace_of_the_whole_document_changes_nothing() -> None:
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    scene = read(f'<robot xmlns="http://drake.mit.edu"><link name="a"/><link name="b"/>{joint}</robot>')
    assert [node.name for node in scene] == ["a", "b"]


def test_a_pointer_of_git_lfs_for_a_mesh_is_named(robot: Path) -> None:
    for path in robot.parents[1].rglob("*.stl"):
        path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    with pytest.raises(MeshError, match=r"'tetra\.stl': a pointer of Git LFS.* git lfs pull"):
        load_scene(robot)


def test_a_link_within_itself_is_refused() -> None:
    joint = '<joint name="{0}" type="fixed"><parent link="{1}"/><child link="{2}"/></joint>'
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    with pytest.raises(MeshError, match="is a part of itself"):
        read(f"<robot>{links}{joint.format('1', 'b', 'c')}{joint.format('2', 'c', 'b')}</robot>")


def test_xacro_and_document_types_are_refused(tmp_path: Path) -> None:
    xacro = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="a" value="1"/></robot>'
    with pytest.raises(MeshError, match=r"it is xacro, from which URDF is made: xacro FILE -o robot\.urdf"):
        read(xacro)
    path = tmp_path / "robot.urdf.xacro"
    path.write_text(xacro, "utf-8")
    with pytest.raises(MeshError, match=r"robot\.urdf\.xacro: it is xacro"):
        load_scene(path)
    with pytest.raises(MeshError, match="it declares a document type"):
        read('<!DOCTYPE robot [<!ENTITY a "b">]><robot><link name="&a;"/></robot>')
    assert len(read('<!-- <!DOCTYPE a> --><?a <!DOCTYPE b> ?><robot><link name="a"/></robot>')) == 1
    # The namespace alone is what xacro leaves behind.
    assert len(read('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a"/></robot>')) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-7"])
@pytest.mark.parametrize("kind", ["urdf", "dae"])
def test_no_document_type_is_taken_whatever_its_encoding(tmp_path: Path, kind: str, encoding: str) -> None:
    (tmp_path / "other").write_text("b", "ascii")
    for declared in ('<!ENTITY e "b">', f'<!ENTITY e SYSTEM "{(tmp_path / "other").as_uri()}">'):
        body = '<robot><link name="&e;"/></robot>' if kind == "urdf" else TRIANGLE_DAE.partition("?>")[2]
        text = f"<!-- a --><!DOCTYPE a [{declared}]>{body.replace('100 0 0', '&e; 0 0')}"
        data = f'<?xml version="1.0" encoding="{encoding}"?>'
        if encoding == "utf-7":  # in which ASCII need not stand for itself
            made = data.encode() + text.replace("<", "+ADw-").replace("&", "+ACY-").encode()
        else:
            made = (data + text).encode(encoding)
        with pytest.raises(MeshError, match=r"declares a document type|is not XML"):
            load_mesh(io.BytesIO(made), file_type=kind)


def test_entities_that_expand_cost_nothing() -> None:
    entities = "".join(f'<!ENTITY e{i + 1} "{f"&e{i};" * 10}">' for i in range(12))
    for text in ('name="&e12;"/>', 'name="a">&e12;</link>'):
        for _ in within_cpu_s(0.1):
            with pytest.raises(MeshError, match="it declares a document type"):
                read(f'<!DOCTYPE robot [<!ENTITY e0 "ha">{entities}]><robot><link {text}</robot>')


def test_thousands_of_spheres_are_counted_as_they_are_made() -> None:
    """Before, 14,000 of them took 4 s and 378 MB until they were refused."""
    sphere = '<visual><geometry><sphere radius="1.{}"/></geometry></visual>'
    text = f'<robot><link name="a">{"".join(map(sphere.format, range(40)))}</link></robot>'
    with pytest.raises(MeshError, match=r"line 1: expands to more than 2,000 points of 16 numbers"):
        load_scene(io.BytesIO(text.encode()), file_type="urdf", limits=FileLimits(points=2_000))
    assert len(read(f'<robot><link name="a">{sphere.format(5) * 40}</link></robot>')) == 1


def test_models_in_many_scales_and_colors_are_counted_as_they_are_made(robot: Path) -> None:
    """Before, 3,000 scales of a model took 1.7 GB until they were refused."""
    mesh = '<mesh filename="meshes/tetra.stl" scale="1 1 {}"/>'
    color = '<mesh filename="meshes/tetra.stl"/></geometry><material name=""><color rgba="0 0 0.{} 1"/></material>'
    for geometry, end in ((mesh, "</geometry>"), (color, "")):
        visuals = [f"<visual><geometry>{geometry.format(number)}{end}</visual>" for number in range(10, 50)]
        robot.write_text(f'<robot><link name="a">{"".join(visuals)}</link></robot>', "utf-8")
        with pytest.raises(MeshError, match=r"line 1: expands to more than 20 points of 16 numbers"):
            load_scene(robot, limits=FileLimits(points=20))
        robot.write_text(f'<robot><link name="a">{visuals[0] * 40}</link></robot>', "utf-8")
        assert len(load_scene(robot, limits=FileLimits(points=20))["a"].models) == 40


def test_the_material_of_a_model_is_looked_through_once(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, 500 scales of a model with 360 kB of material took 2 s."""
    has_colors, looked = urdf._has_colors, []

    def look(mesh: Mesh) -> bool:
        looked.append(mesh)
        return has_colors(mesh)

    monkeypatch.setattr(urdf, "_has_colors", look)
    mesh = '<visual><geometry><mesh filename="meshes/tetra.stl" scale="1 1 {}"/></geometry></visual>'
    robot.write_text(f'<robot><link name="a">{"".join(map(mesh.format, range(1, 9)))}</link></robot>', "utf-8")
    assert len(load_scene(robot)["a"].models) == 8
    assert len(looked) == 1


def test_paths_of_missing_files_are_not_resolved(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, a megabyte of names with many folders took 7 s, as each folder of each was looked at in each place."""
    resolve = Path.resolve
    resolved: list[Path] = []

    def count(path: Path, strict: bool = False) -> Path:
        resolved.append(path)
        return resolve(path, strict)

    monkeypatch.setattr(Path, "resolve", count)
    counts = []
    for n in (1, 30):
        names = [f'<mesh filename="package://p{i}/{"a/" * 50}b.stl"/>' for i in range(n)]
        visuals = "".join(f"<visual><geometry>{name}</geometry></visual>" for name in names)
        robot.write_text(f'<robot><link name="a">{visuals}</link></robot>', "utf-8")
        resolved.clear()
        with pytest.warns(MeshWarning, match="which was not found"):
            load_scene(robot)
        counts.append(len(resolved))
    assert counts[0] == counts[1]


def test_a_path_is_looked_up_once(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    find, names = ModelFinder.find, []

    def look(finder: ModelFinder, name: str) -> Path | None:
        names.append(name)
        return find(finder, name)

    monkeypatch.setattr(ModelFinder, "find", look)
    visual = '<visual><geometry><mesh filename="{}.stl"/></geometry></visual>'
    visuals = visual.format("meshes/tetra") * 5 + visual.format("none") * 5
    robot.write_text(f'<robot><link name="a">{visuals}</link></robot>', "utf-8")
    with pytest.warns(MeshWarning, match="'none.stl', which was not found"):
        assert len(load_scene(robot)["a"].models) == 5
    assert names == ["meshes/tetra.stl", "none.stl"]


def test_names_that_no_system_has_are_not_looked_for(tmp_path: Path) -> None:
    """Before, a name of a megabyte took two minutes, for each of its parts was looked for with all before it."""
    path = tmp_path / "robot.urdf"
    for scheme in ("package://p/", "", "file://"):
        path.write_text(
            f'<robot><link name="a"><visual><geometry><mesh filename="{scheme}{"a/" * 50_000}b.stl"/></geometry>'
            "</visual></link></robot>"
        )
        for _ in within_cpu_s(0.1):
            with pytest.warns(MeshWarning, match="which was not found"), pytest.raises(MeshError, match="no points"):
                load_mesh(path)


def test_limits_hold(robot: Path) -> None:
    for limits, message in (
        (FileLimits(nodes=4), "expands to more than 4 nodes"),
        (FileLimits(depth=2), "its nodes are more than 2 deep"),
        (FileLimits(unpacked_bytes=100), "unpacks to more than the 100 bytes"),
        (FileLimits(faces=5), "more than FileLimits"),
    ):
        with pytest.raises(MeshError, match=message):
            load_scene(robot, limits=limits)


def test_an_isolated_robot_keeps_its_joints(robot: Path) -> None:
    scene, isolated = load_scene(robot), load_scene(robot, isolated=True)
    assert [repr(joint) for joint in isolated.joints.values()] == [repr(joint) for joint in scene.joints.values()]
    poses = {"shoulder": 0.5, "slide": 0.2}
    np.testing.assert_array_equal(isolated.posed(poses).world("tip"), scene.posed(poses).world("tip"))


def test_a_format_without_joints_is_said_to_lose_them(robot: Path, tmp_path: Path) -> None:
    scene = load_scene(robot)
    with pytest.warns(MeshWarning, match="glTF does not hold .*5 joints"):
        save_mesh(scene.posed({"shoulder": 0.5}), tmp_path / "arm.glb")
    again = load_scene(tmp_path / "arm.glb")
    np.testing.assert_allclose(again.world("tip"), scene.posed({"shoulder": 0.5}).world("tip"), atol=1e-6)


def test_the_command_poses_tells_and_moves(robot: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(robot)]) == 0
    told = capfd.readouterr().out
    assert "joints    shoulder (-1.5..2), slide (0..0.3), finger (follows slide), tip_joint (follows finger)\n" in told
    assert "units     metre\n" in told
    moved = tmp_path / "moved.ply"
    assert main(["transform", str(robot), str(moved), "--pose", "shoulder=45deg,slide=0.1"]) == 0
    scene = load_scene(robot).posed({"shoulder": np.pi / 4, "slide": 0.1})
    tip = scene.world("tip")[:3, 3]
    assert np.linalg.norm(load_mesh(moved).positions - tip, axis=1).min() < 1e-6
    pictures = [tmp_path / f"{name}.png" for name in ("zero", "posed")]
    assert main(["render", str(robot), "-o", str(pictures[0]), "--size", "64,64"]) == 0
    assert main(["render", str(robot), "-o", str(pictures[1]), "--size", "64,64", "--pose", "shoulder=1"]) == 0
    assert pictures[0].read_bytes() != pictures[1].read_bytes()
    capfd.readouterr()
    for pose, message in (
        ("shoulder=9", "--pose: poses['shoulder'] must lie in -1.5..2, the limits of the joint"),
        ("shoulder", "--pose: expected JOINT=VALUE or JOINT=VALUEdeg, separated by commas, got 'shoulder'"),
    ):
        assert main(["render", str(robot), "-o", str(pictures[0]), "--pose", pose]) == 2
        assert message in capfd.readouterr().err


def test_collada_is_read_in_metres_with_its_colors(tmp_path: Path) -> None:
    path = tmp_path / "triangle.dae"
    path.write_text(TRIANGLE_DAE, "utf-8")
    mesh = load_mesh(path)
    np.testing.assert_allclose(mesh.positions, [(1, 0, 0), (1.1, 0, 0), (1, 0.2, 0.3)], atol=1e-7)
    assert np.asarray(mesh.attributes.face["color"]).tolist() == [[255, 51, 102, 255]]
    path.write_text(TRIANGLE_DAE.replace('url="#e"', 'url="#f"'), "utf-8")
    with pytest.warns(MeshWarning, match="without material '#m' \\(there is no effect '#f'\\)"):
        np.testing.assert_allclose(load_mesh(path).positions, mesh.positions)
    for text, message in (
        ("<!DOCTYPE a><COLLADA/>", "it declares a document type"),
        ("<COLLADA/>", "it is not COLLADA"),
        (
            TRIANGLE_DAE.replace("<instance_geometry", "<x").replace("</instance_geometry", "</x"),
            "it shows no triangles",
        ),
    ):
        path.write_text(text, "utf-8")
        with pytest.raises(MeshError, match=message):
            load_mesh(path)


def test_nodes_of_collada_are_counted_before_they_are_expanded() -> None:
    """Before, 2 kB meant a thousand triangles, a line more four thousand, and so on."""
    for n_levels, message in ((2, ""), (12, "its nodes: expands to more than .* nodes"), (-1, "a part of itself")):
        nodes = ['<node id="b0"><instance_geometry url="#g"/></node>']
        nodes += [f'<node id="b{i + 1}">{f"""<instance_node url="#b{i}"/>""" * 4}</node>' for i in range(abs(n_levels))]
        library = f"<library_nodes>{''.join(nodes)}</library_nodes>"
        if n_levels < 0:
            library = library.replace('<instance_geometry url="#g"/>', '<instance_node url="#b1"/>')
        text = TRIANGLE_DAE.replace("<library_visual_scenes>", f"{library}<library_visual_scenes>").replace(
            "<translate>", f'<node><instance_node url="#b{abs(n_levels)}"/></node><translate>'
        )
        if message:
            with pytest.raises(MeshError, match=message):
                load_mesh(io.BytesIO(text.encode()), file_type="dae")
        else:
            assert load_mesh(io.BytesIO(text.encode()), file_type="dae").n_faces == 17


@pytest.mark.parametrize(("module", "kind"), [("lxml", "urdf"), ("lxml", "dae")])
def test_without_the_extra_the_error_names_it(monkeypatch: pytest.MonkeyPatch, module: str, kind: str) -> None:
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(MissingExtraError, match=r"pip install 'gpu_xform\[robots\]'"):
        load_mesh(io.BytesIO(b"<robot/>"), file_type=kind)


def test_nodes_are_counted_before_their_shapes_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, all shapes of a file were made first: 3.5 s for a megabyte of cylinders."""
    made: list[Any] = []
    make = urdf._MAKERS["box"]

    def count(sizes: tuple[float, ...]) -> Mesh:
        made.append(sizes)
        return make(sizes)

    monkeypatch.setitem(urdf._MAKERS, "box", count)
    boxes = "".join(f'<visual><geometry><box size="{i} 1 1"/></geometry></visual>' for i in range(1, 100))
    text = f'<robot><link name="r">{boxes}</link></robot>'
    with pytest.raises(MeshError, match="expands to more than 10 nodes"):
        load_mesh(io.BytesIO(text.encode()), file_type="urdf", limits=FileLimits(nodes=10))
    assert len(made) == 11


_BOXES = ARM.replace("<mesh", "<box").replace("filename", 'size="1 1 1" f')


@pytest.mark.parametrize("size", ["1.7e308", "5e-324", "3"])
def test_the_length_of_an_axis_neither_overflows_nor_underflows(size: str) -> None:
    scene = read(_BOXES.replace('<axis xyz="0 3 4"/>', f'<axis xyz="{size} 0 -{size}"/>'))
    np.testing.assert_allclose(scene.joints["shoulder"].axis, [2**-0.5, 0.0, -(2**-0.5)], rtol=1e-15)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('offset="0.25"', 'offset="1e308"'),
        ('<origin xyz="0.2 0 0"/><axis xyz="1 0 0"/>', '<origin xyz="1.7e308 0 0"/><axis xyz="1 0 0"/>'),
    ],
)
def test_a_follower_beyond_the_largest_numbers_is_refused(old: str, new: str) -> None:
    text = _BOXES.replace(old, new)
    text = text.replace('"finger" type="continuous"', '"finger" type="prismatic"').replace('r="0.5"', 'r="1e10"')
    text = text.replace('offset="0.25"', 'offset="1.7e308"')
    with pytest.raises(MeshError, match=r"joint '(finger|tip_joint)': its place is not finite"):
        read(text)
