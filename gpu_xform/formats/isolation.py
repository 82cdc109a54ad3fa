"""Isolation: a model file is read in a process of its own, with limits of the system, and its arrays come back.

Nothing that the child sends is trusted: no pickles, every array is checked against the shared memory, and the mesh or
the scene is built, and so checked, here.
"""

import gc
import json
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from .._core.limited_process import begin_limited, describe_end, limit_work, run_limited
from ..errors import ArgumentError, MeshError, MeshWarning, MissingExtraError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ._warn import warn
from .isolation_models import build_mesh, build_scene, describe_mesh, describe_scene
from .isolation_values import create_memory, decode, dump, encode
from .limits import FileLimits

DEFAULT_CPU_S = 60.0
DEFAULT_MEMORY_BYTES = 4 << 30
_COLLECTIONS = 20_000, 50, 100  # objects until garbage is collected, and how often the older ones are looked through
_MAX_ANSWER_BYTES = 1 << 28

Model = TypeVar("Model", Mesh, Scene)
_COMMAND = "from gpu_xform.formats import isolation, registry; isolation.serve(registry.read_bytes, registry.prepare)"


def read_isolated_mesh(
    data: bytes, kind: str, folder: Path | None, tolerance: float | None, limits: FileLimits
) -> Mesh:
    """Return the mesh of a file of a type, read in a child; only MeshError and MissingExtraError are raised for it.

    Raises ArgumentError where the system limits neither memory nor time.
    """
    return _read_in_child(data, kind, folder, tolerance, limits, build_mesh)


def read_isolated_scene(
    data: bytes, kind: str, folder: Path | None, tolerance: float | None, limits: FileLimits
) -> Scene:
    """Return the scene of a file of a type that has scenes, as `read_isolated_mesh` returns a mesh."""
    return _read_in_child(data, kind, folder, tolerance, limits, build_scene)


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
    memory = create_memory()
    request = {
        "kind": kind,
        "folder": None if folder is None else str(folder.absolute()),
        "tolerance": tolerance,
        "limits": asdict(replace(limits, cpu_s=cpu_s, memory_bytes=memory_bytes)),
        "memory": memory,
        "parent": os.getpid(),
        "is_scene": build is build_scene,
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
    try:
        return build(decode(answer["model"], memory))
    except (MeshError, MemoryError):
        raise
    except Exception as error:  # whatever a child that a file has taken over may answer
        raise MeshError(f"the process that read it gave no model: {type(error).__name__}: {error}") from None


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
    return dump(answer)


def _read(read: Callable[..., Mesh | Scene], data: bytes, request: dict[str, Any], limits: FileLimits) -> Any:
    folder = None if request["folder"] is None else Path(request["folder"])
    model = read(data, request["kind"], folder, request["tolerance"], limits, request["is_scene"])
    described = describe_scene(model) if isinstance(model, Scene) else describe_mesh(model)
    return encode(described, request["memory"], request["limits"]["memory_bytes"])
