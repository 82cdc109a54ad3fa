"""URDF, robots of links that joints move (https://wiki.ros.org/urdf/XML), read through lxml."""

import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .. import matrices
from .._core.error_context import prefix_errors
from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from .._core.types import Float64Array
from ..errors import ArgumentError, MeshError
from ..geometry.attributes import Attributes
from ..geometry.joints import JOINT_KINDS, Joint, Mimic, resolve_mimics
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ._text import quote, quote_end
from ._warn import warn
from ._xml import parse_xml
from .gltf import merge_scene
from .gltf_placements import make_names
from .limits import budget
from .urdf_files import PACKAGE_SCHEMES, ModelFinder
from .vrml_shapes import Polygons, make_box, make_cylinder, make_sphere

ReadModel = Callable[[bytes, str, Path], Mesh | None]

_MAX_DEPTH = 1024
_MAX_NAMED = 4
_MADE_DISCOUNT = 2  # thousands of spheres, each of its own size, and models in scales and colours
_Z_FROM_Y = matrices.rotate_x(90, degrees=True)  # the primitives of VRML stand along y, those of URDF along z
_WHITE = (255, 255, 255, 255)  # of what has no colour, so that `fill="file"` draws all
_LIMITED = ("revolute", "prismatic")


def read(data: bytes, folder: Path | None = None, *, read_model: ReadModel) -> Mesh:
    """Return all that the links show, in metres, with every joint at 0. Raises as `read_scene` does."""
    scene = read_scene(data, folder, read_model=read_model)
    mesh = merge_scene(scene)
    return mesh.with_attributes(mesh.attributes, metadata={"urdf": dict(scene.metadata["urdf"])})


def read_scene(data: bytes, folder: Path | None = None, *, read_model: ReadModel) -> Scene:
    """Return a node per link, and the joints between them, in metres, with every joint at 0.

    folder : where the file is, for the meshes that it names
    read_model : reads a model file of a type, in a folder; None for a type that is not known

    Raises MeshError for a file that is no robot, for links that form no tree, and for damaged meshes; MissingExtraError
    if the extra `robots` is not installed.
    """
    robot = _parse(data)
    links = _index(robot, "link")
    joints = _read_joints(robot, links)
    parents = {joint.node: parent for joint, parent in joints}
    order = _sort_links(list(links), parents)
    budget().spell_nodes(len(links))
    visuals = _Visuals(robot, folder, read_model)
    by_node = {joint.node: joint for joint, _ in joints}
    shown = [(link, visuals.of(links[link])) for link in order]
    extra_names = iter(_name_visuals(order, shown))
    described = {"name": robot.get("name") or "", "holds": [f"{len(joints)} joints"] if joints else []}
    scene = Scene(metadata={"urdf": described}, joints=[joint for joint, _ in joints])
    mimics = _resolve(by_node)
    for link, parts in shown:
        budget().take_nodes(1, "its links")
        joint = by_node.get(link)
        place = np.eye(4)
        if joint is not None:
            place = _place_follower(joint, mimics[joint.name]) if joint.name in mimics else joint.origin
        node = scene.add(name=link, parent=parents.get(link), transform=place)
        for _, mesh, origin in parts:
            if np.array_equal(origin, np.eye(4)):
                node.show(mesh)
            else:
                scene.add(mesh, name=next(extra_names), parent=node, transform=origin)
    visuals.tell()
    return scene


def _parse(data: bytes) -> Any:
    """Return the element <robot>."""
    root = parse_xml(data, "URDF")
    from lxml import etree

    if any("xacro" in (etree.QName(element).namespace or "") for element in root.iter(etree.Element)):
        raise MeshError("it is xacro, from which URDF is made: xacro FILE -o robot.urdf")
    if etree.QName(root).localname != "robot":
        raise MeshError(f"it is not URDF: its root is <{etree.QName(root).localname}>, not <robot>")
    namespace = etree.QName(root).namespace
    for element in root.iter(etree.Element) if namespace else ():
        if etree.QName(element).namespace == namespace:
            element.tag = etree.QName(element).localname  # some tools declare a namespace for all, such as Drake's
    return root


def _index(robot: Any, tag: str) -> dict[str, Any]:
    """Return the elements of a tag by their names; raise MeshError for one without a name, and for two of one name."""
    found: dict[str, Any] = {}
    for element in robot.findall(tag):
        name = element.get("name")
        if not name:
            raise MeshError(f"line {element.sourceline}: a {tag} has no name")
        if name in found:
            raise MeshError(f"line {element.sourceline}: there are two {tag}s {quote(name)}")
        found[name] = element
    return found


def _read_joints(robot: Any, links: dict[str, Any]) -> list[tuple[Joint, str]]:
    """Return the joints, each with the link that is the parent."""
    found: dict[str, tuple[Joint, str]] = {}
    for name, element in _index(robot, "joint").items():
        owner = f"joint {quote(name)}"
        parent, child = (_get_link(element, tag, links, owner) for tag in ("parent", "child"))
        if child in found:
            raise MeshError(f"{owner}: link {quote(child)} has a parent already")
        kind = element.get("type")
        if kind not in JOINT_KINDS:
            raise MeshError(f"{owner}: the type must be one of {', '.join(JOINT_KINDS)}, got {quote(str(kind))}")
        axis = _read_numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0), owner)
        axis = np.ldexp(axis, -math.frexp(np.abs(axis).max())[1])  # whose length neither overflows nor underflows
        length = math.hypot(*axis)
        if not length and kind not in ("fixed", "floating"):
            raise MeshError(f"{owner}: the axis has no direction")
        limit, mimic = element.find("limit"), element.find("mimic")
        lower, upper = (None, None)
        if limit is not None and kind in _LIMITED:
            lower, upper = (_read_number(limit, side, 0.0, owner) for side in ("lower", "upper"))
            if lower > upper:
                raise MeshError(f"{owner}: the lower limit {lower:g} is above the upper one, {upper:g}")
        follows = None
        if mimic is not None:
            numbers = (_read_number(mimic, *given, owner) for given in (("multiplier", 1.0), ("offset", 0.0)))
            follows = Mimic(mimic.get("joint") or "", *numbers)
        origin = _read_origin(element, owner)
        unit = axis / length if length else np.array([1.0, 0.0, 0.0])
        found[child] = Joint(name, kind, child, origin, unit, lower, upper, follows), parent
    return list(found.values())


def _get_link(joint: Any, tag: str, links: dict[str, Any], owner: str) -> str:
    element = joint.find(tag)
    name = None if element is None else element.get("link")
    if name not in links:
        raise MeshError(f"{owner}: the {tag} must be a link, got {quote(str(name))}")
    return str(name)


def _sort_links(links: list[str], parents: dict[str, str]) -> list[str]:
    """Return the links, each after its parent; raise MeshError unless they form one tree."""
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        named = ", ".join(map(quote, roots[:_MAX_NAMED])) or "none"
        raise MeshError(f"one link must have no parent, got {named}")
    children: dict[str, list[str]] = {}
    for child, parent in parents.items():
        children.setdefault(parent, []).append(child)
    order, level, depth = list[str](), roots, 0
    while level:
        budget().require_depth(depth, _MAX_DEPTH)
        order += level
        level = [child for link in level for child in children.get(link, ())]
        depth += 1
    if len(order) < len(links):
        reached = set(order)
        raise MeshError(f"link {quote(next(link for link in links if link not in reached))} is a part of itself")
    return order


def _resolve(by_node: dict[str, Joint]) -> dict[str, Mimic]:
    try:
        return resolve_mimics({joint.name: joint for joint in by_node.values()})
    except ArgumentError as error:
        raise MeshError(str(error)) from None


def _place_follower(joint: Joint, mimic: Mimic) -> Float64Array:
    """Return the matrix of a joint that follows one which is at 0."""
    place = np.full((4, 4), np.inf)
    if math.isfinite(mimic.offset):
        with np.errstate(over="ignore", invalid="ignore"):
            place = joint.matrix(mimic.offset)
    if not np.isfinite(place).all():
        raise MeshError(f"joint {quote(joint.name)}: its place is not finite, {mimic.offset:g} along or about its axis")
    return place


_Part = tuple[str | None, Mesh, Float64Array]
"""The name of a visual, if it has one, its mesh, and where it is in its link."""


def _name_visuals(links: list[str], shown: list[tuple[str, list[_Part]]]) -> list[str]:
    """Return the names of the visuals that are nodes of their own, which no link and no other has."""
    given = [
        name or f"{link} visual"
        for link, parts in shown
        for name, _, origin in parts
        if not np.array_equal(origin, np.eye(4))
    ]
    return make_names([*links, *given], "visual")[len(links) :]


class _Visuals:
    """What links show; files and shapes that are alike are one mesh."""

    def __init__(self, robot: Any, folder: Path | None, read_model: ReadModel) -> None:
        self._finder = None if folder is None else ModelFinder(folder)
        self._read_model = read_model
        self._colors = {
            element.get("name"): color
            for element in robot.iter("material")
            if (color := _read_color(element)) is not None
        }
        self._paths: dict[str, Path | None] = {}  # of the names of files
        self._files: dict[Path, Mesh | None] = {}
        self._colored = set[Path]()  # the files that have colours of their own
        self._made: dict[Any, Mesh] = {}
        self._lost: Counter[str] = Counter()
        self._lacks_package = False

    def of(self, link: Any) -> list[_Part]:
        """Return the parts of a link."""
        parts = []
        for visual in link.findall("visual"):
            owner = f"link {quote(link.get('name'))}"
            geometry = visual.find("geometry")
            shape = None if geometry is None else next(geometry.iterchildren(tag=None), None)
            if shape is None:
                raise MeshError(f"{owner}: a visual has no geometry")
            mesh = self._make(shape, self._find_color(visual), owner)
            if mesh is not None:
                budget().take_nodes(1, "its links")  # before the next is made
                parts.append((visual.get("name"), mesh, _read_origin(visual, owner)))
        return parts

    def tell(self) -> None:
        """Warn of what was not found or cannot be read."""
        if not self._lost:
            return
        named = [text for text, _ in self._lost.most_common(_MAX_NAMED)]
        more = f", and {len(self._lost) - len(named)} more" if len(self._lost) > len(named) else ""
        hint = "; ROS_PACKAGE_PATH says where packages are" if self._lacks_package else ""
        warn(f"left out: {', '.join(named)}{more}{hint}")

    def _find_color(self, visual: Any) -> tuple[int, ...]:
        material = visual.find("material")
        if material is None:
            return _WHITE
        own = _read_color(material)
        return self._colors.get(material.get("name"), _WHITE) if own is None else own

    def _make(self, shape: Any, color: tuple[int, ...], owner: str) -> Mesh | None:
        """Return the mesh of a geometry in a colour, None for one that is left out."""
        if shape.tag == "mesh":
            return self._make_of_file(shape, color, owner)
        sizes: tuple[float, ...]
        match shape.tag:
            case "box":
                sizes = tuple(_read_numbers(shape, "size", None, owner))
            case "cylinder":
                sizes = _read_number(shape, "radius", None, owner), _read_number(shape, "length", None, owner)
            case "sphere":
                sizes = (_read_number(shape, "radius", None, owner),)
            case other:
                self._lost[f"geometry <{other}>"] += 1
                return None
        if min(sizes) <= 0:
            raise MeshError(f"{owner}: a {shape.tag} must have a size above 0, got {min(sizes):g}")
        key = shape.tag, sizes, color
        if key not in self._made:
            made = _MAKERS[shape.tag](sizes)
            budget().take_numbers((made.positions.size + len(made.indices)) // _MADE_DISCOUNT, shape.sourceline)
            self._made[key] = _paint(made, color)
        return self._made[key]

    def _make_of_file(self, shape: Any, color: tuple[int, ...], owner: str) -> Mesh | None:
        name = shape.get("filename")
        if not name:
            raise MeshError(f"{owner}: a mesh has no file name")
        scale = tuple(_read_numbers(shape, "scale", (1.0, 1.0, 1.0), owner))
        if name not in self._paths:
            self._paths[name] = None if self._finder is None else self._finder.find(name)
        path = self._paths[name]
        if path is None:
            self._lost[f"{quote_end(name)}, which was not found"] += 1
            self._lacks_package |= name.startswith(PACKAGE_SCHEMES)
            return None
        key = path, scale, color
        if key not in self._made:
            is_another = path in self._files
            if not is_another:
                self._files[path] = read = self._read_file(path)
                if read is not None and _has_colors(read):
                    self._colored.add(path)
            mesh = self._files[path]
            if mesh is None:
                self._lost[f"{quote_end(name)}, of a type that cannot be read"] += 1
                return None
            if is_another:
                budget().take_numbers((mesh.positions.size + len(mesh.indices)) // _MADE_DISCOUNT, shape.sourceline)
            with prefix_errors(owner):
                moved = mesh if scale == (1.0, 1.0, 1.0) else mesh.transformed(np.diag([*scale, 1.0]))
            self._made[key] = moved if path in self._colored else _paint(moved, color)
        return self._made[key]

    def _read_file(self, path: Path) -> Mesh | None:
        kind = path.suffix.lower().lstrip(".")
        data = budget().read_beside(path)
        with prefix_errors(quote(path.name)):
            if is_lfs_pointer(data):
                raise MeshError(POINTER_WORDS)
            return self._read_model(data, kind, path.parent)


def _has_colors(mesh: Mesh) -> bool:
    """Return whether a mesh has colours of its own, which URDF's are not put over, as RViz has it."""
    attributes = mesh.attributes
    return any("color" in table for table in (attributes.point, attributes.corner, attributes.face)) or any(
        "baseColorFactor" in str(content) for content in attributes.material.values()
    )


def _paint(mesh: Mesh, color: tuple[int, ...]) -> Mesh:
    attributes = mesh.attributes
    face = {**attributes.face, "color": np.tile(np.array(color, np.uint8), (mesh.n_faces, 1))}
    made = Attributes(attributes.point, attributes.corner, face, labels=attributes.labels, material=attributes.material)
    return mesh.with_attributes(made)


def _make_mesh(polygons: Polygons) -> Mesh:
    offsets = np.concatenate([[0], np.cumsum(polygons.sizes)])
    return Mesh.from_offsets(polygons.points, offsets, polygons.corners)


_MAKERS: dict[str, Callable[[tuple[float, ...]], Mesh]] = {
    "box": lambda sizes: _make_mesh(make_box(np.array(sizes))),
    "cylinder": lambda sizes: _make_mesh(make_cylinder(*sizes)).transformed(_Z_FROM_Y),
    "sphere": lambda sizes: _make_mesh(make_sphere(*sizes)).transformed(_Z_FROM_Y),
}


def _read_color(material: Any) -> tuple[int, ...] | None:
    """Return the colour of a material from 0 to 255; None if it names another, or a texture alone."""
    color = material.find("color")
    if color is None:
        return None
    rgba = _read_numbers(color, "rgba", None, f"material {quote(str(material.get('name')))}", 4)
    return tuple(np.round(255.0 * np.clip(rgba, 0.0, 1.0)).astype(int).tolist())


def _read_origin(element: Any, owner: str) -> Float64Array:
    """Return the matrix of an <origin>: turned about the fixed axes x, y and z by roll, pitch and yaw, then moved."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    roll, pitch, yaw = _read_numbers(origin, "rpy", (0.0, 0.0, 0.0), owner)
    turned = matrices.rotate_z(yaw) @ matrices.rotate_y(pitch) @ matrices.rotate_x(roll)
    moved: Float64Array = matrices.translate(*_read_numbers(origin, "xyz", (0.0, 0.0, 0.0), owner)) @ turned
    return moved


def _read_numbers(
    element: Any, attribute: str, default: tuple[float, ...] | None, owner: str, count: int = 3
) -> Float64Array:
    """Return the numbers of an attribute (count,), or `default`; None makes it required."""
    text = None if element is None else element.get(attribute)
    if text is None and default is not None:
        return np.array(default)
    try:
        numbers = np.array([float(word) for word in (text or "").split()])
    except ValueError:
        numbers = np.empty(0)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise MeshError(f"{owner}: {attribute} must be {count} numbers, got {quote(str(text))}")
    return numbers


def _read_number(element: Any, attribute: str, default: float | None, owner: str) -> float:
    (number,) = _read_numbers(element, attribute, None if default is None else (default,), owner, 1)
    return float(number)
