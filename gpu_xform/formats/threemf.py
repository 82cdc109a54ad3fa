"""3MF, a ZIP container, through trimesh, lxml and networkx; its uncompressed size is checked first."""

import zipfile
from importlib import import_module
from io import BytesIO

from ..errors import MeshError, MissingExtraError
from ..geometry.mesh import Mesh
from . import _trimesh

_MOST_BYTES = 1 << 30
_MOST_RATIO = 200  # 3MF's XML shrinks to a tenth or less; bombs to a thousandth


def read(data: bytes) -> Mesh:
    """Return all triangles.

    Raises MeshError for a container that unpacks to more than 1 GiB or 200 times its size, MissingExtraError where the
    extra `3mf` is not installed.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as container:
            unpacked = sum(entry.file_size for entry in container.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise MeshError(f"not a ZIP container: {error}") from None
    most = min(_MOST_BYTES, _MOST_RATIO * len(data))
    if unpacked > most:
        raise MeshError(f"unpacks to {unpacked} bytes, more than the {most} that are allowed")
    _require_extra()
    return _trimesh.load(data, "3mf")


def _require_extra() -> None:
    """Raise MissingExtraError where trimesh would fail for want of a library."""
    try:
        for name in ("lxml.etree", "networkx"):
            import_module(name)
    except ImportError:
        raise MissingExtraError("3MF needs lxml and networkx: pip install 'gpu_xform[3mf]'") from None
