"""Scenes: trees of named nodes with a matrix each, and the models that the nodes show."""

import copy
from collections import defaultdict
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import matrices
from .._core.error_context import prefix_errors
from .._core.pictured import Pictured
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..errors import ArgumentError, ArgumentTypeError
from ..matrices._composition import require_broadcast
from .instances import Instances, gather_instances
from .joints import Joint, is_number_of_joint, name_joints, place_nodes
from .nodes import (
    Node,
    SceneModel,
    as_local_matrices,
    as_local_matrix,
    as_read_only,
    as_weights,
    require_finite_world,
    summarize_node,
)
from .nodes import Shown as Shown  # where pickles of older versions look for it
from .scene_animation import NodePoses, SceneAnimation
from .trimesh_scenes import add_nodes_of_trimesh, is_trimesh_scene, to_trimesh_scene

_MAX_REPR_LINES = 40


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
        node = Node(name, above, as_local_matrix(np.eye(4) if transform is None else transform, "transform"))
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
        return require_finite_world(_multiply_down(path), path[0])

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
            posed._nodes[node_name]._transform = as_read_only(placed)
        for name, matrix in poses.items():
            if name in numbers:
                continue
            if name not in posed:
                known = "nodes of this scene" if not joints or name in joints else "joints or nodes of this scene"
                raise ArgumentError.expecting("poses", f"name {known}", f"{name!r}{name_joints(joints, name)}")
            posed._nodes[name]._transform = as_local_matrices(matrix, f"poses[{name!r}]")
        for name, factors in weights.items():
            if name not in posed:
                raise ArgumentError.expecting("weights", "name nodes of this scene", repr(name))
            posed._nodes[name]._weights = as_weights(factors, f"weights[{name!r}]")
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
        return gather_instances(tuple(self))

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
            lines.append("  " * depths[node.name] + summarize_node(node))
        return "\n".join(lines)


def make_unused_name(stem: str, number: int, used: Container[str]) -> str:
    """Return "STEM NUMBER", with the first number from `number` on that makes a name not in `used`."""
    while f"{stem} {number}" in used:
        number += 1
    return f"{stem} {number}"


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
