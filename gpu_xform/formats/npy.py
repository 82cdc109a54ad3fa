"""NumPy arrays of points (`.npy`): point clouds, without faces."""

from typing import BinaryIO

from .._core.npy import read_array, write_array
from ..errors import MeshError
from ..geometry.mesh import Mesh


def read(data: bytes) -> Mesh:
    """Return the points of an array (n, 3) of real numbers; raise MeshError for another array or a damaged file."""
    try:
        points = read_array(data)
    except ValueError as error:
        raise MeshError(f"not an .npy file of numbers: {error}") from None
    return Mesh(points)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write the points of a mesh as an array (n, 3) of float64; raise MeshError for a mesh with faces."""
    if mesh.n_faces:
        raise MeshError(f"NPY holds points only, and would lose the faces of this mesh, {mesh.n_faces:,} of them")
    write_array(mesh.positions, file)
