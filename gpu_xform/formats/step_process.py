"""Triangles of a STEP file, made by Open CASCADE in a process of its own.

Its C++ prints to the standard streams, and a damaged file may end the process that it runs in, or go on for ever; so
memory and time of this process are limited, where the system can.
"""

import os
from importlib.util import find_spec

from .._core.limited_process import describe_end, describe_memory, run_limited
from ..errors import MeshError, MissingExtraError
from .limits import budget

# A circle has at least 21 edges, however small it is.
_ANGLE_RAD = 0.3
# The library exceeds what it is asked for by up to 2.06 times, measured on spheres, cones, cylinders and tori.
_SAFETY = 0.4
# trimesh would be imported for an extension that is not used; without it the import takes a tenth of the time.
_PROGRAM = """
import os, sys
from gpu_xform._core.limited_process import begin_limited, limit_work
tolerance, angle, cpu_s, memory_bytes, is_parallel, parent = sys.argv[1:]
begin_limited(int(parent))
answer, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
os.dup2(nothing, 1), os.dup2(nothing, 2)
data = sys.stdin.buffer.read()
sys.modules["trimesh"] = None
import cascadio

def work():
    try:
        return cascadio.load(
            data,
            tol_linear=float(tolerance),
            tol_angular=float(angle),
            merge_primitives=False,
            use_parallel=is_parallel == "True",
        )
    except RuntimeError as error:
        if "malloc failed" in str(error):
            raise MemoryError from None
        raise

limit_work(work, answer, float(cpu_s), int(memory_bytes))
"""
# What the process may take unless `FileLimits` says otherwise: ten times of what files of many balls take, which have
# the most triangles per byte. An endless loop ends, and memory is left for others.
_FREE_CPU_S, _CPU_S_PER_BYTE = 600, 600e-6
_BYTES_PER_THREAD = 16 << 20  # for its stack and more; Open CASCADE waits for ever for one that could not be begun
_FREE_MEMORY_BYTES, _MEMORY_BYTES_PER_BYTE = 4 << 30, 4 << 10


def make_glb(data: bytes, tolerance_mm: float) -> bytes:
    """Return the faces of a STEP file as a GLB in metres, a primitive per face; a part is a node, or several.

    Raises MeshError for a file that cannot be read, MissingExtraError if the extra `cad` is not installed.
    """
    if find_spec("cascadio") is None:
        raise MissingExtraError("STEP needs cascadio: pip install 'gpu_xform[cad]'")
    limits = budget().limits
    cpu_s = limits.cpu_s or _FREE_CPU_S + _CPU_S_PER_BYTE * len(data)
    memory_bytes = limits.memory_bytes or _FREE_MEMORY_BYTES + _MEMORY_BYTES_PER_BYTE * len(data)
    is_parallel = memory_bytes > _BYTES_PER_THREAD * (os.cpu_count() or 1)
    options = _SAFETY * tolerance_mm, _ANGLE_RAD, cpu_s, memory_bytes, is_parallel, os.getpid()
    ended = run_limited(_PROGRAM, [data], cpu_s, memory_bytes, list(map(repr, options)))
    if ended.code == 1 or not (ended.code or ended.is_late or ended.printed):
        raise MeshError("Open CASCADE cannot read it" + describe_memory(ended, memory_bytes))
    if ended.code or ended.is_late:
        raise MeshError(describe_end(ended, "Open CASCADE", cpu_s, memory_bytes))
    return ended.printed
