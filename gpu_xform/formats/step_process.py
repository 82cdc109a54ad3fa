"""Triangles of a STEP file, made by Open CASCADE in a process of its own.

Its C++ prints to the standard streams, and a damaged file may end the process that it runs in.
"""

import os
import subprocess
import sys
from importlib.util import find_spec

from ..errors import MeshError, MissingExtraError

# A circle has at least 21 edges, however small it is.
_ANGLE_RAD = 0.3
# The library exceeds what it is asked for by up to 2.06 times, measured on spheres, cones, cylinders and tori.
_SAFETY = 0.4
# trimesh would be imported for an extension that is not used; without it the import takes a tenth of the time.
_PROGRAM = """
import os, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
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


def make_glb(data: bytes, tolerance_mm: float) -> bytes:
    """Return the faces of a STEP file as a GLB in metres, a primitive per face; a part is a node, or several.

    Raises MeshError for a file that cannot be read, MissingExtraError if the extra `cad` is not installed.
    """
    if find_spec("cascadio") is None:
        raise MissingExtraError("STEP needs cascadio: pip install 'gpu_xform[cad]'")
    child = subprocess.run(  # noqa: S603 - our own interpreter, with our own program
        [sys.executable, "-c", _PROGRAM, repr(_SAFETY * tolerance_mm), repr(_ANGLE_RAD)],
        input=data,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        check=False,
    )
    if child.returncode or not child.stdout:
        raise MeshError(f"Open CASCADE cannot read it{_explain(child.returncode)}")
    return child.stdout


def _explain(code: int) -> str:
    """Return why the process ended: this one may be limited, and then that one is."""
    if code >= 0:
        return ""
    reason = f", and ended with signal {-code}"
    if sys.platform != "win32":
        import resource

        if resource.getrlimit(resource.RLIMIT_CPU)[0] != resource.RLIM_INFINITY:
            reason += ", within the limits FileLimits(cpu_s=..., memory_bytes=...)"
    return reason
