"""Tangent edges: those of a B-rep across which its surface goes on without a corner, as at the end of a fillet.

Where one bounds the picture of a body, the surface beside it turns from the eye within a pixel, as at a silhouette.
"""

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..geometry.edges import compute_plane_normals, find_edge_faces, has_brep_faces, measure_turns
from ..geometry.mesh import Mesh, pack_pairs
from ..gpu.layouts import CANDIDATE

MAX_TURN_DEGREES = 50.0  # between the facets beside it, which are coarser than the surface


def find_tangent_edges(mesh: Mesh, drawn: IndexArray) -> npt.NDArray[np.void]:
    """Return which of the edges (m, 2) may be silhouettes: `layouts.CANDIDATE` (m,), the others of one face twice.

    It is empty if there are no tangent edges, as in all meshes that do not come from a B-rep.
    """
    none = np.zeros(0, CANDIDATE)
    if not has_brep_faces(mesh) or len(drawn) == 0:
        return none
    found = find_edge_faces(mesh)
    two = np.flatnonzero(
        (found.n_faces == 2) & ~found.segments & np.isin(pack_pairs(*found.edges.T), pack_pairs(*drawn.T))
    )
    normals = compute_plane_normals(mesh, lambda: found)
    one, other = normals[found.faces[two]].swapaxes(0, 1)
    tangent = two[measure_turns(one, other, found.inconsistent_winding[two]) <= MAX_TURN_DEGREES]
    if len(tangent) == 0:
        return none
    candidates = np.zeros(len(drawn), CANDIDATE)
    candidates["edge"] = drawn
    keys = pack_pairs(*drawn.T)
    order = np.argsort(keys)
    rows = order[np.searchsorted(keys, pack_pairs(*found.edges[tangent].T), sorter=order)]
    candidates["faces"][rows] = found.faces[tangent]
    candidates["is_turned"][rows] = found.inconsistent_winding[tangent]
    return candidates
