"""What streams of Draco in glTF hold, decoded when that is not too much."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.interrupts import defer_interrupts
from ..errors import MeshError
from .gltf_draco_counts import DracoCounts, count_components, count_draco


@dataclass(frozen=True, eq=False)
class DracoMesh:
    """What a stream holds."""

    columns: dict[int, npt.NDArray[Any]]
    """By the id of the attribute."""
    corners: npt.NDArray[np.uint32]
    """(c, 1)"""


def decode_draco(
    data: bytes, require: Callable[[DracoCounts], None], require_components: Callable[[int], None]
) -> DracoMesh:
    """Return what a stream holds; raise MeshError if it is damaged, and ImportError without DracoPy.

    require : raises an error if it is too much
    require_components : raises one if that are too many numbers per point
    """
    with defer_interrupts():
        import DracoPy

    require(count_draco(data))
    require_components(count_components(data))
    try:
        mesh = DracoPy.decode(data)
    except MemoryError:
        raise
    except Exception as error:  # whatever damaged content brings the library to
        raise MeshError(str(error)) from None
    columns = {attribute["unique_id"]: attribute["data"] for attribute in mesh.attributes}
    return DracoMesh(columns, np.asarray(mesh.faces, np.uint32).reshape(-1, 1))
