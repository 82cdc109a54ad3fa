"""3MF, a ZIP container, read with trimesh, lxml and networkx; its uncompressed size is checked first."""

import zipfile
from importlib import import_module
from io import BytesIO

from ..errors import MeshError, MissingExtraError
from ..geometry.mesh import Mesh
from . import _trimesh

_MAX_UNPACKED_BYTES = 1 << 30
_MAX_RATIO = 200  # the XML of 3MF is compressed about 10 times, a ZIP bomb 1000 times


def read(data: bytes) -> Mesh:
    """Return all triangles.

    Raises MeshError for a container that unpacks to more than 1 GiB or 200 times its size, and MissingExtraError if the
    extra `3mf` is not installed.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as container:
            unpacked = sum(entry.file_size for entry in container.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise MeshError(f"not a ZIP container: {error}") from None
    max_bytes = min(_MAX_UNPACKED_BYTES, _MAX_RATIO * len(data))
    if unpacked > max_bytes:
        raise MeshError(f"unpacks to {unpacked} bytes, more than the {max_bytes} that are allowed")
    _require_extra()
    return _trimesh.load(data, "3mf")


def _require_extra() -> None:
    """Raise MissingExtraError if a library that trimesh needs is missing."""
    try:
        for name in ("lxml.etree", "networkx"):
            import_module(name)
    except ImportError:
        raise MissingExtraError("3MF needs lxml and networkx: pip install 'gpu_xform[3mf]'") from None
