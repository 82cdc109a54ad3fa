"""Scenes: trees of named nodes with a matrix each, and the models that the nodes show."""

import copy
from collections import defaultdict
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from .. import matrices
from .._core.arguments import as_real_array, as_square_matrices, as_square_matrix
from .._core.error_context import prefix_errors
from .._core.pictured import Pictured
from .._core.public import public
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array, MatrixLike, StrPath
from ..errors import ArgumentError, ArgumentTypeError
from ..matrices._affine import require_finite
from ..matrices._composition import require_broadcast
from .deformable_mesh import DeformableMesh
from .foreign_meshes import mesh_of_other_library
from .joints import Joint, place_nodes
from .mesh import Mesh
from .scene_animation import NodePoses, SceneAnimation
from .trimesh_scenes import add_nodes_of_trimesh, is_trimesh_scene, to_trimesh_scene


class PointsOnDevice(Protocol):
    """The part of a `PointBuffer` that scenes use; its folder comes after this one."""

    @property
    def shape(self) -> tuple[int, int]:
        """The number of points, and of their coordinates."""
        ...

    def device_points(self) -> Any:
        """Return the points on the device."""
        ...


@runtime_checkable
class SupportsAsModel(Protocol):
    """An object that knows what is drawn of it, such as `Springs`."""

    def as_model(self) -> Any:
        """Return what is drawn of it at present: a Mesh or a PointBuffer."""
        ...


SceneModel: TypeAlias = Mesh | DeformableMesh | npt.NDArray[Any] | PointsOnDevice | SupportsAsModel | StrPath

_MAX_REPR_LINES = 40


class Shown(NamedTuple):
    """A model, and its style: keywords of `render`."""

    model: Any
    style: Mapping[str, Any]


class Instances(NamedTuple):
    """All instances of a model that have the same style.

    node : the name of the first node that shows the model
    style : keywords of `render`
    transform : (k, 4, 4), from the model to the world, one per instance
    nodes : the name of the node that shows each instance, (k,)
    """

    node: str
    model: Any
    style: Mapping[str, Any]
    transform: Float64Array
    nodes: tuple[str, ...] = ()


class Node:
    """A node of a scene: a name, a matrix, and any number of models. `Scene.add` makes it."""

    # Of the class, so that scenes pickled before there were such have them.
    _is_visible = True
    _weights: Float64Array | None = None
    _instances: Float64Array | None = None
    _metadata: Mapping[str, Any] = MappingProxyType({})

    def __init__(self, name: str, parent: str | None, transform: Float64Array) -> None:
        self._name = name
        self._parent = parent
        self._transform = transform
        self._models: Sequence[Shown] = ()

    @property
    def name(self) -> str:
        """The name, unique in the scene."""
        return self._name

    @property
    def parent(self) -> str | None:
        """The name of the parent node; None for the world. `Scene.move` changes it."""
        return self._parent

    @property
    def transform(self) -> Float64Array:
        """The matrix from this node to its parent: (4, 4) float64, read-only.

        To change it, assign another matrix, or an object with `as_matrix()`.

        Raises
        ------
        ArgumentError
            If another shape, or a matrix with numbers that are not finite, is assigned.
        """
        return self._transform

    @transform.setter
    def transform(self, matrix: MatrixLike) -> None:
        """Replace the matrix."""
        self._transform = _as_local_matrix(matrix, "transform")

    @property
    def models(self) -> tuple[Shown, ...]:
        """The models with their styles, in the order of the calls of `show`."""
        return tuple(self._models)

    @property
    def visible(self) -> bool:
        """Whether the models of this node, and of all that is in it, are drawn."""
        return self._is_visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        """Show or hide the node."""
        if not isinstance(visible, bool):
            raise ArgumentTypeError.expecting("visible", "be True or False", repr(visible))
        self._is_visible = visible

    @property
    def metadata(self) -> Mapping[str, Any]:
        """What else a file says of the node, by the name of its format, such as {"gltf": {"extras": ...}}."""
        return self._metadata

    @metadata.setter
    def metadata(self, metadata: Mapping[str, Any]) -> None:
        """Put other metadata in their place."""
        self._metadata = dict(metadata)

    @property
    def weights(self) -> Float64Array | None:
        """The morph weights of the models (t,), read-only; None for those of the models. Assign others to change them.

        ArgumentError is raised for another shape, a NaN, an infinity.
        """
        return self._weights

    @weights.setter
    def weights(self, weights: npt.ArrayLike | None) -> None:
        """Put other weights in their place."""
        self._weights = None if weights is None else _as_weights(weights, "weights")

    @property
    def instances(self) -> Float64Array | None:
        """The matrices from copies of the models to this node: (k, 4, 4), read-only; None for one copy in its place.

        Assign others to change them; the nodes placed in this one have no copies.
        ArgumentError is raised for another shape, a NaN, an infinity.
        """
        return self._instances

    @instances.setter
    def instances(self, matrices: MatrixLike | None) -> None:
        """Put other matrices in their place."""
        if matrices is None:
            self._instances = None
            return
        stack = as_square_matrices(matrices, "instances", 4).reshape(-1, 4, 4)
        stack.flags.writeable = False
        self._instances = stack

    def show(self, model: SceneModel, **style: Any) -> None:
        """Add a model to this node.

        Parameters
        ----------
        model : Mesh, (n, 3) array of points, PointBuffer, or path of a model file
            The model, in the coordinates of this node.
        **style
            Keywords of `render` that say how the model is drawn.

        Raises
        ------
        ArgumentError
            If `transform` is among the keywords: the node has one already.
        """
        if "transform" in style:
            raise ArgumentError.expecting("transform", "be that of a node", reason="a model stands where its node is")
        if not isinstance(self._models, list):  # from `with_models`, or pickled before it was one
            self._models = [*self._models]
        own = mesh_of_other_library(model)
        self._models.append(Shown(model if own is None else own, style))

    def __repr__(self) -> str:
        return f"<Node {_summarize(self)}>"


@public
class Scene(Pictured):
    """A tree of named nodes. A node's world matrix is the product of the matrices from the world down to the node.

    `scene["name"]` is a node, `len` is the number of nodes, and iteration gives the nodes depth first, each before its
    children. A model that several nodes show is uploaded once, and drawn once per node.
    """

    # Of the class, so that scenes pickled before there were such have them.
    _animations: Mapping[str, SceneAnimation] = MappingProxyType({})

    _metadata: Mapping[str, Any] = MappingProxyType({})
    _joints: Mapping[str, Joint] = MappingProxyType({})

    def __init__(
        self,
        *,
        animations: Iterable[SceneAnimation] = (),
        metadata: Mapping[str, Any] | None = None,
        joints: Iterable[Joint] = (),
    ) -> None:
        self._nodes: dict[str, Node] = {}
        self._joints = {joint.name: joint for joint in joints}
        self._metadata = dict(metadata or {})
        self._animations = {animation.name: animation for animation in animations}

    @property
    def animations(self) -> Mapping[str, SceneAnimation]:
        """The animations that the scene's file holds, by name; `animate(scene, scene.animations[name])` plays one."""
        return MappingProxyType(dict(self._animations))

    @property
    def joints(self) -> Mapping[str, Joint]:
        """The joints of a robot, by name; `posed` takes a number for each that does not follow another."""
        return MappingProxyType({name: joint for name, joint in self._joints.items() if joint.node in self._nodes})

    @property
    def metadata(self) -> Mapping[str, Any]:
        """What else the scene's file holds, by the name of its format: for glTF its materials, textures, extras."""
        return MappingProxyType(dict(self._metadata))

    def add(
        self,
        model: SceneModel | None = None,
        *,
        name: str | None = None,
        parent: str | Node | None = None,
        transform: MatrixLike | None = None,
        **style: Any,
    ) -> Node:
        """Add a node, and return it.

        Parameters
        ----------
        model : Mesh, (n, 3) array of points, PointBuffer, or path of a model file, optional
            What the node shows. A node without a model can carry other nodes. `Node.show` adds more models.
        name : str, optional
            Unique in the scene; "node 1", "node 2", ... by default.
        parent : Node or str, optional
            The parent node or its name; the world by default.
        transform : (4, 4) numbers, or an object with `as_matrix()`, optional
            From the node to its parent; the identity by default.
        **style
            Keywords of `render` that say how the model is drawn.

        Returns
        -------
        Node

        Raises
        ------
        ArgumentError
            For a name that is taken, an unknown parent, an invalid matrix, or a style without a model.
        ArgumentTypeError
            If the name is not a string.
        """
        name = self._new_name(name)
        above = None if parent is None else self._node(parent, "parent").name
        node = Node(name, above, _as_local_matrix(np.eye(4) if transform is None else transform, "transform"))
        if model is not None:
            node.show(model, **style)
        elif style:
            raise ArgumentError.expecting("model", "be given where a style is", f"{', '.join(style)} alone")
        self._nodes[name] = node
        return node

    def move(self, node: str | Node, parent: str | Node | None) -> None:
        """Move a node, with its descendants, to another parent; its matrix does not change.

        Parameters
        ----------
        node : Node or str
            The node or its name.
        parent : Node, str or None
            The new parent or its name; None for the world.

        Raises
        ------
        ArgumentError
            For an unknown node, or a parent that is the node itself or one of its descendants.
        """
        moved = self._node(node, "node")
        target = None if parent is None else self._node(parent, "parent")
        if target is not None and moved in self._path(target):
            raise ArgumentError.expecting("parent", f"not be within {moved.name!r} itself", repr(target.name))
        moved._parent = None if target is None else target.name

    def remove(self, node: str | Node) -> None:
        """Remove a node and its descendants.

        Parameters
        ----------
        node : Node or str
            The node or its name.

        Raises
        ------
        ArgumentError
            For an unknown node.
        """
        removed = {self._node(node, "node").name}
        for below in self:
            if below.parent in removed:
                removed.add(below.name)
        for name in removed:
            del self._nodes[name]

    def world(self, node: str | Node) -> Float64Array:
        """Return the matrix from a node to the world.

        Parameters
        ----------
        node : Node or str
            The node or its name.

        Returns
        -------
        (4, 4) float64, or (..., 4, 4) in a scene that is posed by stacks

        Raises
        ------
        ArgumentError
            For an unknown node, if the product overflows, or if stacks of poses do not broadcast.
        """
        path = self._path(self._node(node, "node"))
        return _require_finite_world(_multiply_down(path), path[0])

    @classmethod
    def from_trimesh(cls, source: Any) -> "Scene":
        """Return the nodes, matrices and geometries of a `trimesh.Scene`.

        Parameters
        ----------
        source : trimesh.Scene
            Its arrays are copied. A geometry that several nodes show is one mesh here too. Cameras and lights are left
            out.

        Returns
        -------
        Scene

        Raises
        ------
        ArgumentTypeError
            `source` is not a `trimesh.Scene`.
        """
        if not is_trimesh_scene(source):
            raise ArgumentTypeError.expecting("source", "be a trimesh.Scene", type(source).__name__)
        scene = cls()
        add_nodes_of_trimesh(scene, source)
        return scene

    def to_trimesh(self) -> Any:
        """Return a `trimesh.Scene` of the visible nodes and their models, with polygons as triangles.

        Styles are left out. A mesh that deforms is as the node's `weights` say.

        Returns
        -------
        trimesh.Scene

        Raises
        ------
        ArgumentTypeError
            A model is not a mesh, but points on a device or a path.
        """
        require_one_pose(self)
        return to_trimesh_scene(self)

    def transform_between(self, source: str | Node, target: str | Node) -> Float64Array:
        """Return the matrix from one node to another: `target_from_source`.

        It goes up to the nearest node that both are in, and down again: what lies above has no part in it.

        Parameters
        ----------
        source, target : Node or str
            The nodes or their names.

        Returns
        -------
        (4, 4) float64, or (..., 4, 4) in a scene that is posed by stacks

        Raises
        ------
        ArgumentError
            For an unknown node, if the product overflows, or if stacks of poses do not broadcast.
        SingularMatrixError
            If a matrix on the way down has no inverse.
        """
        up, down = self._path(self._node(source, "source")), self._path(self._node(target, "target"))
        while up and down and up[-1] is down[-1]:
            up.pop()
            down.pop()
        with prefix_errors(f"from {self._node(source, 'source').name!r} to {self._node(target, 'target').name!r}"):
            return matrices.chain(_multiply_down(up), matrices.inverse(_multiply_down(down)))

    def follow(
        self,
        node: str | Node,
        poses: "SceneAnimation | Callable[[float], Mapping[str, MatrixLike] | Scene]",
        *,
        start: float = 0.0,
    ) -> Callable[[float], Float64Array]:
        """Return the motion of what is fixed to a node, as a function of the time, while the scene is posed.

        The matrix world(t) world(start)^-1 moves what was fixed to the node at the start to where it is at time t. So
        pinned points follow a node with `Springs.simulate(..., move_pins=scene.follow("hand", poses))`, and obstacles
        with `transform=`.

        Parameters
        ----------
        node : Node or str
            The node or its name.
        poses : SceneAnimation, or function
            One of `animations`; or a function of the time in seconds that returns the matrices of nodes by name, as
            `posed` takes them, or a scene.
        start : float
            The time in seconds at which nothing has moved yet.

        Returns
        -------
        function
            Of the time in seconds: a (4, 4) float64 matrix of the world.

        Raises
        ------
        ArgumentError
            For an unknown node, if `poses` names one, or if the scene is posed by stacks.
        ArgumentTypeError
            If `poses` is neither an animation nor a function.
        SingularMatrixError
            If the node's matrix at the start has no inverse.
        """
        name = self._node(node, "node").name
        if not isinstance(poses, SceneAnimation) and not callable(poses):
            raise ArgumentTypeError.expecting(
                "poses", "be a SceneAnimation or a function of the time", type(poses).__name__
            )

        def world_at(time: float) -> Float64Array:
            pose = poses.at(time) if isinstance(poses, SceneAnimation) else poses(time)
            if isinstance(pose, NodePoses):
                pose = pose.transforms
            scene = pose if isinstance(pose, Scene) else self.posed(pose)
            require_one_pose(scene)
            return scene.world(name)

        start_from_world = matrices.inverse(world_at(start))
        return lambda time: world_at(time) @ start_from_world

    def posed(
        self,
        poses: Mapping[str, MatrixLike | npt.ArrayLike],
        weights: Mapping[str, npt.ArrayLike] = MappingProxyType({}),
    ) -> "Scene":
        """Return a scene of the same models, with other matrices or morph weights for some nodes.

        Parameters
        ----------
        poses : dict of str to (4, 4) numbers, to objects with `as_matrix()`, or to a number
            The new matrix, from the node to its parent, by the node's name. Skinned meshes follow their joints.
            Stacks (..., 4, 4) broadcast: `world` and `transform_between` then give stacks, and nothing can be drawn.
            A number, or (k,) numbers, are for one of `joints`, by its name: radians, or the unit of the scene. Joints
            that follow it move along, by as much as they follow, whatever their own limits; other joints stay.
        weights : dict of str to (t,) numbers, optional
            The new morph weights of what the node shows, by the node's name.

        Returns
        -------
        Scene

        Raises
        ------
        ArgumentError
            For an unknown name, an invalid matrix or an invalid weight, a number beyond the limits of its joint, or for
            a joint that follows another.
        ArgumentTypeError
            If `poses` is not a mapping.
        """
        if not isinstance(poses, Mapping):
            raise ArgumentTypeError.expecting("poses", "map names to matrices", type(poses).__name__)
        posed = Scene(animations=self._animations.values(), metadata=self._metadata, joints=self._joints.values())
        posed._nodes = {name: copy.copy(node) for name, node in self._nodes.items()}
        for node in posed._nodes.values():
            node._models = tuple(node._models)
        joints = posed.joints
        numbers = {name: pose for name, pose in poses.items() if name in joints and is_number_of_joint(pose)}
        for node_name, placed in place_nodes(joints, numbers).items():
            posed._nodes[node_name]._transform = _protect(placed)
        for name, matrix in poses.items():
            if name in numbers:
                continue
            if name not in posed:
                known = "nodes of this scene" if not joints or name in joints else "joints or nodes of this scene"
                raise ArgumentError.expecting("poses", f"name {known}", f"{name!r}{did_you_mean(str(name), joints)}")
            posed._nodes[name]._transform = _as_local_matrices(matrix, f"poses[{name!r}]")
        for name, factors in weights.items():
            if name not in posed:
                raise ArgumentError.expecting("weights", "name nodes of this scene", repr(name))
            posed._nodes[name]._weights = _as_weights(factors, f"weights[{name!r}]")
        return posed

    def with_models(self, change: Callable[[Any], Any]) -> "Scene":
        """Return a scene of the same nodes, with every model replaced.

        Parameters
        ----------
        change : callable
            Takes a model, and returns the model to show instead.

        Returns
        -------
        Scene
        """
        changed = self.posed({})
        for node in changed:
            node._models = tuple(shown._replace(model=change(shown.model)) for shown in node._models)
        return changed

    def layers(self) -> list[Instances]:
        """Return the instances of all models, grouped by model and style, in the order of their first appearance.

        Models and arrays are the same if they are one object.

        Returns
        -------
        list of Instances
            Each with the name of the first `node`, the `model`, its `style`, `transform` (k, 4, 4), from the model
            to the world, one matrix per instance, and `nodes`, the names of all k.

        Raises
        ------
        ArgumentError
            If a world matrix overflows, or if the scene is posed by stacks.
        """
        require_one_pose(self)
        worlds: dict[str | None, Float64Array] = {None: np.eye(4)}
        hidden: set[str | None] = set()
        found: dict[Any, tuple[Shown, list[Float64Array], list[str]]] = {}
        with np.errstate(over="ignore", invalid="ignore"):
            for node in self:
                worlds[node.name] = worlds[node.parent] @ node.transform
                if node.parent in hidden or not node.visible:
                    hidden.add(node.name)
            for node in self:
                if node.name in hidden:
                    continue
                for shown in node.models:
                    placed, copies = _place(shown, node, worlds)
                    _, places, nodes = found.setdefault(_make_key(placed), (placed, [], []))
                    places += [_require_finite_world(copy_matrix, node) for copy_matrix in copies]
                    nodes += [node.name] * (len(places) - len(nodes))
        return [
            Instances(nodes[0], shown.model, shown.style, np.stack(places), tuple(nodes))
            for shown, places, nodes in found.values()
            if places
        ]

    def _new_name(self, name: object) -> str:
        """Return `name`, or an unused one for None; raise an error for a name that is taken."""
        if name is None:
            return make_unused_name("node", len(self) + 1, self._nodes)
        if not isinstance(name, str):
            raise ArgumentTypeError.expecting("name", "be a text", repr(name))
        if not name:
            raise ArgumentError.expecting("name", "not be empty")
        if name in self._nodes:
            parent = self._nodes[name].parent
            place = "the world" if parent is None else repr(parent)
            raise ArgumentError.expecting(
                "name", "be new", f"{name!r}, which is in {place} and cannot have a second parent"
            )
        return name

    def _node(self, which: str | Node, argument: str) -> Node:
        """Return the node that an argument means, or raise an error that names the argument."""
        node = self._nodes.get(which) if isinstance(which, str) else which
        if not isinstance(node, Node) or node not in self:
            raise ArgumentError.expecting(argument, "be a node of this scene, or its name", repr(which))
        return node

    def _path(self, node: Node) -> list[Node]:
        """Return `node`, its parent, and so on up to the world."""
        path = [node]
        while path[-1].parent is not None:
            path.append(self._nodes[path[-1].parent])
        return path

    def __getitem__(self, name: str) -> Node:
        return self._node(name, "name")

    def __contains__(self, node: object) -> bool:
        if isinstance(node, Node):
            return self._nodes.get(node.name) is node
        return node in self._nodes

    def __iter__(self) -> Iterator[Node]:
        children = defaultdict(list)
        for node in self._nodes.values():
            children[node.parent].append(node)
        waiting = children[None][::-1]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(children[node.name]))

    def __len__(self) -> int:
        return len(self._nodes)

    def __repr__(self) -> str:
        depths: dict[str | None, int] = {None: 0}
        lines = [f"<Scene: {len(self)} nodes>"]
        for node in self:
            if len(lines) == _MAX_REPR_LINES:
                lines.append(f"  ... and {len(self) - len(lines) + 1} more")
                break
            depths[node.name] = depths[node.parent] + 1
            lines.append("  " * depths[node.name] + _summarize(node))
        return "\n".join(lines)


def make_unused_name(stem: str, number: int, used: Container[str]) -> str:
    """Return "STEM NUMBER", with the first number from `number` on that makes a name not in `used`."""
    while f"{stem} {number}" in used:
        number += 1
    return f"{stem} {number}"


def _require_finite_world(matrix: Float64Array, node: Node) -> Float64Array:
    return require_finite(matrix, f"the world matrix of {node.name!r}")


def is_number_of_joint(pose: object) -> bool:
    """Say whether a pose is a number or a row of numbers, which a joint takes, and not a matrix."""
    if hasattr(pose, "as_matrix"):
        return False
    try:
        array = np.asarray(pose)
    except (TypeError, ValueError):  # of a ragged list
        return False
    return array.ndim < 2 and array.dtype.kind in "iuf"


def require_one_pose(scene: Scene) -> None:
    """Raise `ArgumentError` if a node of a scene has a stack of matrices."""
    for node in scene:
        if node.transform.ndim != 2:
            name = f"the matrix of {node.name!r}"
            raise ArgumentError.expecting(name, "have shape (4, 4) to be drawn or written", node.transform.shape)


def _multiply_down(path: list[Node]) -> Float64Array:
    """Return the product of the matrices of a path, which begins at the lowest node."""
    product = np.eye(4)
    with np.errstate(over="ignore", invalid="ignore"):
        for below in reversed(path):
            require_broadcast(product, below.transform, f"the matrix of {below.name!r}")
            product = product @ below.transform
    return product


def _as_local_matrix(matrix: MatrixLike, argument: str) -> Float64Array:
    return _protect(as_square_matrix(matrix, argument, 4))


def _as_local_matrices(matrix: MatrixLike, argument: str) -> Float64Array:
    return _protect(as_square_matrices(matrix, argument, 4))


def _protect(array: Float64Array) -> Float64Array:
    array.flags.writeable = False
    return array


def _as_weights(weights: npt.ArrayLike, argument: str) -> Float64Array:
    factors = as_real_array(weights, argument)
    if factors.ndim != 1:
        raise ArgumentError.expecting(argument, "have shape (t,)", factors.shape)
    factors.flags.writeable = False
    return factors


def _place(shown: Shown, node: Node, worlds: Mapping[str | None, Float64Array]) -> tuple[Shown, list[Float64Array]]:
    """Return what a node shows as a mesh that is not deformed any more, and where its copies are in the world."""
    world, model = worlds[node.name], shown.model
    if isinstance(model, DeformableMesh):
        skin = model.skin
        missing = [] if skin is None else [name for name in skin.joints if name not in worlds]
        if missing:
            raise ArgumentError.expecting("skin", "have its joints in the scene", repr(missing[0]))
        joints = None if skin is None else np.stack([worlds[name] for name in skin.joints])
        with prefix_errors(f"node {node.name!r}"):
            shown = shown._replace(model=model.posed(node.weights, joints))
        if skin is not None:
            world = np.eye(
                4
            )  # the joints have put it into the world, whatever the matrix of its node (glTF 2.0, 3.7.3.3)
    return shown, [world] if node.instances is None else list(world @ node.instances)


def _make_key(shown: Shown) -> tuple[Any, ...]:
    """Return a key of the model and its style: what has the same key is drawn as instances of one model."""
    return _make_identity(shown.model), frozenset((name, _make_identity(value)) for name, value in shown.style.items())


def _make_identity(value: Any) -> Any:
    """Return a key that is the same for equal texts and numbers, and otherwise for one object alone."""
    try:
        hash(value)
    except TypeError:
        return object, id(value)
    return value


def _describe(model: object) -> str:
    return f"<array {model.shape}>" if isinstance(model, np.ndarray) else repr(model)


def _summarize(node: Node) -> str:
    models = ", ".join(_describe(shown.model) for shown in node.models)
    return f"{node.name!r}: {models}" if models else repr(node.name)
