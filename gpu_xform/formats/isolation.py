"""Isolation: a model file is read in a process of its own, with limits of the system, and its arrays come back.

Nothing that the child sends is trusted: no pickles, every array is checked against the shared memory, and the mesh or
the scene is built, and so checked, here.
"""

import errno
import gc
import json
import math
import mmap
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .._core.limited_process import begin_limited, describe_end, limit_work, run_limited
from .._core.types import Float64Array
from ..errors import ArgumentError, MeshError, MeshWarning, MissingExtraError
from ..geometry.attributes import Attributes, FrozenDict, FrozenTuple, RaggedArray, freeze_value
from ..geometry.deformable_mesh import DeformableMesh, Influences, Skin
from ..geometry.joints import Joint, Mimic
from ..geometry.mesh import Mesh
from ..geometry.nodes import share_instances
from ..geometry.scene import Scene
from ..geometry.scene_animation import Channel, Placement, SceneAnimation
from ._warn import warn
from .limits import FileLimits

DEFAULT_CPU_S = 60.0
DEFAULT_MEMORY_BYTES = 4 << 30
_N_STANDARD_STREAMS = 3
_COLLECTIONS = 20_000, 50, 100  # objects until garbage is collected, and how often the older ones are looked through
_MAX_ANSWER_BYTES = 1 << 28
_FEW_BYTES = 1 << 16  # smaller arrays wait for others, as each write takes its time
_KINDS = "biuf"
_PLAIN = frozenset({bool, float, int, str, type(None)})
_MAX_COPIED = 32  # values of frozen data: so few are sent with each part that has them, in half of the time

Model = TypeVar("Model", Mesh, Scene)
_COMMAND = "from gpu_xform.formats import isolation, registry; isolation.serve(registry.read_bytes, registry.prepare)"


def read_isolated_mesh(
    data: bytes, kind: str, folder: Path | None, tolerance: float | None, limits: FileLimits
) -> Mesh:
    """Return the mesh of a file of a type, read in a child; only MeshError and MissingExtraError are raised for it.

    Raises ArgumentError where the system limits neither memory nor time.
    """
    return _read_in_child(data, kind, folder, tolerance, limits, _build_mesh)


def read_isolated_scene(
    data: bytes, kind: str, folder: Path | None, tolerance: float | None, limits: FileLimits
) -> Scene:
    """Return the scene of a file of a type that has scenes, as `read_isolated_mesh` returns a mesh."""
    return _read_in_child(data, kind, folder, tolerance, limits, _build_scene)


def _read_in_child(
    data: bytes,
    kind: str,
    folder: Path | None,
    tolerance: float | None,
    limits: FileLimits,
    build: Callable[[Any], Model],
) -> Model:
    if not sys.platform.startswith("linux"):
        raise ArgumentError.expecting("isolated", "be False here", reason="only Linux limits a process's memory")
    cpu_s, memory_bytes = limits.cpu_s or DEFAULT_CPU_S, limits.memory_bytes or DEFAULT_MEMORY_BYTES
    memory = _create_memory()
    request = {
        "kind": kind,
        "folder": None if folder is None else str(folder.absolute()),
        "tolerance": tolerance,
        "limits": asdict(replace(limits, cpu_s=cpu_s, memory_bytes=memory_bytes)),
        "memory": memory,
        "parent": os.getpid(),
        "is_scene": build is _build_scene,
    }
    try:
        # The first line is the request, what follows the file.
        parts = [json.dumps(request).encode() + b"\n", data]
        ended = run_limited(_COMMAND, parts, cpu_s, memory_bytes, pass_fds=[memory])
        if ended.code or ended.is_late:
            raise MeshError(describe_end(ended, "the process that read it", cpu_s, memory_bytes))
        if len(ended.printed) > _MAX_ANSWER_BYTES:
            raise MeshError(f"it takes more than {_MAX_ANSWER_BYTES:,} bytes to describe, beside its arrays")
        if not ended.printed:  # its exit code is lost where SIGCHLD is ignored, or another part of the program waits
            limit = f"FileLimits(cpu_s={cpu_s:g}, memory_bytes={memory_bytes})"
            raise MeshError(f"the process that read it gave no answer: maybe it hit a limit, {limit}")
        with _without_collection():
            return _build(_parse_answer(ended.printed), memory, build)
    except MemoryError:
        raise MeshError("this process lacks memory for it") from None
    finally:
        os.close(memory)


@contextmanager
def _without_collection() -> Iterator[None]:
    """Collect no garbage in the block, which makes many small objects and no cycles: it would take most of the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _create_memory() -> int:
    """Return a descriptor of memory to share; never one of the standard streams, which may be closed in a service."""
    import fcntl

    memory = os.memfd_create("gpu_xform")
    try:
        return fcntl.fcntl(memory, fcntl.F_DUPFD_CLOEXEC, _N_STANDARD_STREAMS)
    finally:
        os.close(memory)


def _parse_answer(text: bytes) -> dict[str, Any]:
    try:
        answer = json.loads(text)
    except (ValueError, RecursionError):
        raise MeshError("the process that read it gave no answer") from None
    if not isinstance(answer, dict):
        raise MeshError("the process that read it gave no answer")
    for message in answer.get("warnings", ()):
        warn(str(message))
    if "error" in answer:
        raise (MissingExtraError if answer.get("is_missing") is True else MeshError)(str(answer["error"]))
    return answer


def _build(answer: dict[str, Any], memory: int, build: Callable[[Any], Model]) -> Model:
    """Return the model that an answer describes, with arrays of our own."""
    n_bytes = os.fstat(memory).st_size
    shared = mmap.mmap(memory, n_bytes, access=mmap.ACCESS_READ) if n_bytes else b""
    try:
        return build(_decode(answer["model"], shared, []))
    except (MeshError, MemoryError):
        raise
    except Exception as error:  # whatever a child that a file has taken over may answer
        raise MeshError(f"the process that read it gave no model: {type(error).__name__}: {error}") from None


def _describe_mesh(mesh: Mesh) -> list[Any]:
    of = mesh.attributes
    mappings = of.point, of.corner, of.face, of.labels, of.material, mesh.metadata
    return [mesh.positions, mesh.offsets, mesh.indices, *(each or None for each in mappings)]


def _build_mesh(parts: Any) -> Mesh:
    positions, offsets, indices, point, corner, face, labels, material, metadata = parts
    attributes = Attributes(point, corner, face, labels=labels, material=material)
    return Mesh.from_offsets(positions, offsets, indices, attributes=attributes, metadata=metadata)


class _Parts:
    """Meshes and skins, each described once, however many models have it."""

    def __init__(self) -> None:
        self.described: list[Any] = []
        self._places: dict[int, int] = {}

    def place(self, part: Mesh | Skin) -> int:
        """Return the place of a part, which lives as long as its scene."""
        if id(part) not in self._places:
            self._places[id(part)] = len(self.described)
            self.described.append(
                _describe_mesh(part) if isinstance(part, Mesh) else [list(part.joints), part.joint_from_mesh]
            )
        return self._places[id(part)]


def _describe_deformable(model: DeformableMesh, meshes: _Parts, skins: _Parts) -> list[Any]:
    skin, influences = model.skin, model.influences
    return [
        meshes.place(model.mesh),
        list(model.targets),
        model.weights,
        None if skin is None else skins.place(skin),
        None if influences is None else [influences.joints, influences.weights],
    ]


def _build_deformable(parts: Any, meshes: list[Mesh], skins: list[Skin]) -> DeformableMesh:
    mesh, targets, weights, skin, influences = parts
    return DeformableMesh(
        meshes[mesh],
        targets,
        weights,
        None if skin is None else skins[skin],
        None if influences is None else Influences(*influences),
    )


def _describe_scene(scene: Scene) -> list[Any]:
    """Return the nodes, each before those in it, the models that they show, each once, and the animations.

    What all nodes have comes in columns, as a scene has many of them; what few have comes with their numbers.
    """
    models: dict[int, Any] = {}
    places: dict[int, int] = {}
    nodes = list(scene)
    shown: list[list[int]] = []
    styles: list[list[Any]] = []
    for i, node in enumerate(nodes):
        for k, (model, style) in enumerate(node.models):
            places.setdefault(id(model), len(places))
            models[id(model)] = model
            if style:
                styles.append([i, k, dict(style)])
        shown.append([places[id(model)] for model, _ in node.models])
    columns = [
        [node.name for node in nodes],
        [node.parent for node in nodes],
        np.array([node.transform for node in nodes]).reshape(-1, 4, 4),
        [node.visible for node in nodes],
        shown,
    ]
    others = [
        [i, node.metadata, node.instances, node.weights]
        for i, node in enumerate(nodes)
        if node.metadata or node.instances is not None or node.weights is not None
    ]
    animations = [
        [
            animation.name,
            [[getattr(each, attribute.name) for attribute in fields(Channel)] for each in animation.channels],
            {name: [rest.translation, rest.rotation, rest.scale] for name, rest in animation.placements.items()},
        ]
        for animation in scene.animations.values()
    ]
    meshes, skins = _Parts(), _Parts()
    described = [
        ["deformable", _describe_deformable(model, meshes, skins)]
        if isinstance(model, DeformableMesh)
        else ["mesh", meshes.place(model)]
        for model in models.values()
    ]
    joints = [[getattr(joint, attribute.name) for attribute in fields(Joint)] for joint in scene.joints.values()]
    return [columns, others, styles, described, animations, scene.metadata, joints, meshes.described, skins.described]


def _build_joint(parts: Any) -> Joint:
    name, kind, node, origin, axis, lower, upper, mimic = parts
    return Joint(name, kind, node, origin, axis, lower, upper, None if mimic is None else Mimic(*mimic))


def _build_scene(parts: Any) -> Scene:
    columns, others, styles, described, animations, metadata, joints, described_meshes, described_skins = parts
    meshes = [_build_mesh(parts) for parts in described_meshes]
    skins = [Skin(tuple(map(str, names)), matrices) for names, matrices in described_skins]
    models = [
        _build_deformable(parts, meshes, skins) if kind == "deformable" else meshes[parts] for kind, parts in described
    ]
    built = [
        SceneAnimation(
            str(name),
            tuple(Channel(*channel) for channel in channels),
            {node: Placement(*rest) for node, rest in placements.items()},
        )
        for name, channels, placements in animations
    ]
    scene = Scene(animations=built, metadata=metadata, joints=map(_build_joint, joints))
    style_of = {(i, k): style for i, k, style in styles}
    nodes = []
    for i, (name, parent, transform, is_visible, shown) in enumerate(zip(*columns, strict=True)):
        node = scene.add(name=name, parent=parent, transform=transform)
        node.visible = is_visible
        for k, model in enumerate(shown):
            node.show(models[model], **style_of.get((i, k), {}))
        nodes.append(node)
    checked: dict[int, Float64Array] = {}
    for i, own_metadata, instances, weights in others:
        node = nodes[i]
        node.metadata, node.weights = own_metadata, weights
        if id(instances) in checked:
            share_instances(node, checked[id(instances)])
        else:
            node.instances = instances
            if node.instances is not None:
                checked[id(instances)] = node.instances
    return scene


def _encode(value: Any, append: Callable[[npt.NDArray[Any]], int], known: dict[int, tuple[Any, int]]) -> Any:
    """Return a value as JSON holds it; `append` puts an array into the shared memory, and returns where.

    known : what was encoded, and its number, by its identity: what several parts of the model share is there once
    """
    if type(value) in _PLAIN:  # first, as most are, and to ask for an abstract type is slow
        return value
    if type(value) is list:
        is_plain = _PLAIN.issuperset(map(type, value))
        return value if is_plain else [_encode(each, append, known) for each in value]
    if not isinstance(value, FrozenDict | tuple | np.ndarray | bytes | bytearray | memoryview):
        return _encode_once(value, append, known)
    if id(value) in known:
        return {"again": known[id(value)][1]}
    if isinstance(value, FrozenDict | FrozenTuple):
        is_json = _count_json(value, _MAX_COPIED) <= _MAX_COPIED
        made = {"json": value} if is_json else {"frozen": _encode_once(value, append, known)}
    else:
        made = _encode_once(value, append, known)
    known[id(value)] = value, len(known)
    return made


def _count_json(value: Any, most: int) -> int:
    """Return how many values frozen data hold; more than `most` if they are more, or JSON does not hold them as is.

    Keys count as values do, and each eight characters of a text.
    """
    if type(value) is str:
        return 1 + len(value) // 8
    if type(value) in _PLAIN:
        return 1
    if not isinstance(value, FrozenDict | tuple) or len(value) > most:  # before it is gone through
        return most + 1
    if isinstance(value, tuple):
        parts = list(value)
    elif all(type(key) is str for key in value):
        parts = [part for item in value.items() for part in item]
    else:
        return most + 1
    count = 1
    for part in parts:
        count += _count_json(part, most - count)
        if count > most:
            break
    return count


def _dump(value: Any) -> str:
    return json.dumps(value, default=_thaw)


def _thaw(value: FrozenDict) -> dict[Any, Any]:
    return dict(value.items())


def _encode_once(value: Any, append: Callable[[npt.NDArray[Any]], int], known: dict[int, tuple[Any, int]]) -> Any:
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in _KINDS:
            raise MeshError(f"an attribute of dtype {value.dtype} cannot be carried out of isolation")
        array = np.ascontiguousarray(value)
        return {"array": [append(array), list(array.shape), array.dtype.str]}
    if isinstance(value, RaggedArray):
        return {"ragged": [_encode(value.values, append, known), _encode(value.offsets, append, known)]}
    if isinstance(value, bytes | bytearray | memoryview):
        return {"bytes": _encode_once(np.frombuffer(value, np.uint8), append, known)}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {"map": [[_encode(key, append, known), _encode(each, append, known)] for key, each in value.items()]}
    if isinstance(value, tuple):
        return {"tuple": [_encode(each, append, known) for each in value]}
    if isinstance(value, bool | int | float | str):
        return value
    raise MeshError(f"{type(value).__name__} cannot be carried out of isolation")


def _decode(value: Any, shared: Any, known: list[Any]) -> Any:
    """Return what `_encode` was given, with arrays copied out of the shared memory, each once, and read-only.

    known : what was decoded and cannot change, by its number
    """
    if isinstance(value, list):
        is_plain = _PLAIN.issuperset(map(type, value))
        return value if is_plain else [_decode(each, shared, known) for each in value]
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    match kind:
        case "again":
            return known[content]
        case "json":
            made = freeze_value(content)
        case "frozen":
            ((kind, content),) = content.items()
            made = freeze_value(_decode_once(kind, content, shared, known))
        case _:
            made = _decode_once(kind, content, shared, known)
    if isinstance(made, FrozenDict | tuple | np.ndarray | bytes):
        known.append(made)
    return made


def _decode_once(kind: str, content: Any, shared: Any, known: list[Any]) -> Any:
    match kind:
        case "array":
            start, shape, text = content
            dtype = np.dtype(str(text))
            if dtype.kind not in _KINDS or not all(type(side) is int and side >= 0 for side in [start, *shape]):
                raise ValueError("an array is malformed")
            if start + math.prod(shape) * dtype.itemsize > len(shared):
                raise ValueError("an array is outside of the shared memory")
            array = np.ndarray(shape, dtype, shared, start).copy()
            array.flags.writeable = False
            return array
        case "ragged":
            return RaggedArray(*(_decode(each, shared, known) for each in content))
        case "bytes":
            ((kind, content),) = content.items()
            return _decode_once(kind, content, shared, known).tobytes()
        case "map":
            return {_decode(key, shared, known): _decode(each, shared, known) for key, each in content}
        case "tuple":
            return tuple(_decode(each, shared, known) for each in content)
    raise ValueError(f"unknown content {kind!r}")


def serve(read: Callable[..., Mesh | Scene], prepare: Callable[[str], None]) -> None:
    """Read the file on standard input by functions of the registry, in a child, and answer on standard output.

    The limits count from when all is loaded that a file of its type needs.
    """
    source = sys.stdin.buffer
    request = json.loads(source.readline())
    begin_limited(request["parent"])
    data = source.read()
    prepare(request["kind"])
    # Looking for garbage among many small parts, none of which is any, would take a third of the time.
    gc.freeze()
    gc.set_threshold(*_COLLECTIONS)
    limits = request["limits"]
    work = partial(_answer, read, data, request, FileLimits(**limits))
    limit_work(work, sys.stdout.fileno(), limits["cpu_s"], limits["memory_bytes"])


def _answer(read: Callable[..., Mesh | Scene], data: bytes, request: dict[str, Any], limits: FileLimits) -> bytes:
    """Read a file, and return what came of it; raise MemoryError where that takes too much."""
    answer: dict[str, Any] = {}
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            answer["model"] = _read(read, data, request, limits)
    except MeshError as error:
        answer["error"] = str(error)
    except MissingExtraError as error:
        answer |= {"error": str(error), "is_missing": True}
    except MemoryError:
        raise
    except Exception as error:  # whatever a damaged file brings a reader to
        answer["error"] = f"it cannot be read: {type(error).__name__}: {error}"
    answer["warnings"] = [str(each.message) for each in caught if issubclass(each.category, MeshWarning)]
    return _dump(answer).encode()


def _read(read: Callable[..., Mesh | Scene], data: bytes, request: dict[str, Any], limits: FileLimits) -> Any:
    folder = None if request["folder"] is None else Path(request["folder"])
    model = read(data, request["kind"], folder, request["tolerance"], limits, request["is_scene"])
    arrays = _SharedArrays(request["memory"], request["limits"]["memory_bytes"])
    described = _describe_scene(model) if isinstance(model, Scene) else _describe_mesh(model)
    encoded = _encode(described, arrays.append, {})
    arrays.flush()
    return encoded


class _SharedArrays:
    """Arrays in memory that is shared, one after the other; small ones are written many at a time."""

    def __init__(self, memory: int, memory_bytes: int) -> None:
        self._memory, self._memory_bytes = memory, memory_bytes
        self._end = 0
        self._waiting = bytearray()

    def append(self, array: npt.NDArray[Any]) -> int:
        """Return where the array is when all is written."""
        start = self._end
        self._end += array.nbytes
        if array.nbytes >= _FEW_BYTES:
            self.flush()
            self._write(array.reshape(-1).view(np.uint8).data)
            return start
        self._waiting += array.tobytes()
        if len(self._waiting) >= _FEW_BYTES:
            self.flush()
        return start

    def flush(self) -> None:
        """Write what waits for more."""
        self._write(memoryview(self._waiting))
        self._waiting = bytearray()

    def _write(self, rest: memoryview) -> None:
        import resource  # of Linux alone

        try:
            while rest:
                rest = rest[os.write(self._memory, rest) :]
        except OSError as error:
            if error.errno not in (errno.EFBIG, errno.ENOSPC):
                raise
            most_bytes = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
            if error.errno == errno.EFBIG and 0 <= most_bytes < self._memory_bytes:
                told = f"its arrays take more than {most_bytes:,} bytes, the limit of the size of files (ulimit -f)"
                raise MeshError(told) from None
            raise MemoryError from None  # the limit of the size of files is that of memory
