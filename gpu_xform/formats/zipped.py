"""3MF, a ZIP container, through trimesh (which asks for lxml and networkx); its uncompressed size is checked first."""

import zipfile
from io import BytesIO

from ..errors import MeshError
from ..mesh import Mesh
from . import _trimesh

_MOST_BYTES = 1 << 30
_MOST_RATIO = 200  # 3MF's XML shrinks to a tenth or less; bombs to a thousandth


def read(data: bytes) -> Mesh:
    """Return all triangles; raise MeshError for a container that unpacks to more than 1 GiB or 200 times its size."""
    try:
        with zipfile.ZipFile(BytesIO(data)) as container:
            unpacked = sum(entry.file_size for entry in container.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise MeshError(f"not a ZIP container: {error}") from None
    most = min(_MOST_BYTES, _MOST_RATIO * len(data))
    if unpacked > most:
        raise MeshError(f"unpacks to {unpacked} bytes, more than the {most} that are allowed")
    return _trimesh.load(data, "3mf")
