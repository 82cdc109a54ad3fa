"""Triangles of a STEP file, made by Open CASCADE in a process of its own.

Its C++ prints to the standard streams, and a damaged file may end the process that it runs in, or go on for ever; so
memory and time of this process are limited, where the system can.
"""

import os
import subprocess
import sys
from importlib.util import find_spec

from ..errors import MeshError, MissingExtraError
from .limits import budget

# A circle has at least 21 edges, however small it is.
_ANGLE_RAD = 0.3
# The library exceeds what it is asked for by up to 2.06 times, measured on spheres, cones, cylinders and tori.
_SAFETY = 0.4
# trimesh would be imported for an extension that is not used; without it the import takes a tenth of the time.
_PROGRAM = """
import math, os, sys
if sys.platform == "linux":
    import ctypes, signal
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG: it ends when who waits for it is killed
    if os.getppid() != int(sys.argv[5]):
        os._exit(1)
try:
    import resource
    used = resource.getrusage(resource.RUSAGE_SELF)
    limits = {
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_CPU: math.ceil(used.ru_utime + used.ru_stime + float(sys.argv[3])),
        resource.RLIMIT_AS: int(sys.argv[4]),
    }
    for kind, most in limits.items():
        hard = resource.getrlimit(kind)[1]
        most = min(most, sys.maxsize)
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (most, most))
except (ImportError, OSError, ValueError):  # not of this system, or not of all its kinds
    pass
answer, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
os.dup2(nothing, 1), os.dup2(nothing, 2)
data = sys.stdin.buffer.read()
sys.modules["trimesh"] = None
import cascadio
glb = cascadio.load(data, tol_linear=float(sys.argv[1]), tol_angular=float(sys.argv[2]), merge_primitives=False)
with os.fdopen(answer, "wb") as file:
    file.write(glb)
os._exit(0)
"""
# What the process may take unless `FileLimits` says otherwise: ten times of what files of many balls take, which have
# the most triangles per byte. An endless loop ends, and memory is left for others.
_FREE_CPU_S, _CPU_S_PER_BYTE = 600, 600e-6
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
    numbers = repr(_SAFETY * tolerance_mm), repr(_ANGLE_RAD), repr(cpu_s), repr(memory_bytes), str(os.getpid())
    child = subprocess.run(  # noqa: S603 - our own interpreter, with our own program
        [sys.executable, "-c", _PROGRAM, *numbers],
        input=data,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        check=False,
    )
    if child.returncode or not child.stdout:
        ended = f", and ended with signal {-child.returncode}" if child.returncode < 0 else ""
        allowed = f"{cpu_s:.3g} s of a processor and {memory_bytes:,} bytes"
        is_limited = ended or limits.cpu_s or limits.memory_bytes
        hint = f"; it may take {allowed}, the limits FileLimits(cpu_s=..., memory_bytes=...)" if is_limited else ""
        raise MeshError(f"Open CASCADE cannot read it{ended}{hint}")
    return child.stdout
