"""Silhouettes: edges between faces that look at the eye and faces that look away, extracted anew for each view."""

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..gpu import layouts, uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import choose_workgroup_size, count_workgroups
from ..gpu.device import GpuDevice
from ..gpu.dispatch import dispatch
from .draw_list import EDGE_BYTES

NO_FACE = 2**32 - 1
EDGE_ON_SINE = 1e-4  # as in extract_silhouette.wgsl


def find_silhouette(
    candidates: npt.NDArray[np.void], planes: npt.NDArray[np.float32], eye: npt.NDArray[np.float64]
) -> IndexArray:
    """Return the edges (m, 2) that `extract_silhouette` leaves, found on the host, which any number of faces fits."""
    eye = eye / (np.abs(eye).max() or 1.0)
    towards, edge_on = planes @ eye, EDGE_ON_SINE * np.linalg.norm(eye[:3])
    has_two = candidates["faces"][:, 1] != NO_FACE
    first, second = np.where(has_two[:, None], candidates["faces"], 0).T
    sign = np.where(candidates["is_turned"] == 1, -1.0, 1.0)
    is_drawn = ~has_two | ((towards[first] > edge_on) != (sign * towards[second] > edge_on))
    edges: IndexArray = candidates["edge"][is_drawn].astype(np.int64)
    return edges


def extract_silhouette(
    device: GpuDevice,
    candidates: Buffer,
    n_candidates: int,
    planes: Buffer,
    eye: npt.NDArray[np.float64],
    *,
    keeps_others: bool = False,
) -> Buffer:
    """Return the edges (n_candidates, 2) uint32 that `Lines` takes, without points for those not seen edge-on.

    candidates : `layouts.CANDIDATE` (n_candidates,)
    planes : (f, 4) float32, each face's (normal, offset) in the points' frame, positive before the face
    eye : (4,), in the points' frame, homogeneous; w = 0 for a direction towards it
    keeps_others : whether to return the others, without points for those seen edge-on

    The caller releases the result.
    """
    edges = Buffer(device.context, EDGE_BYTES * n_candidates, label="silhouette: edges")
    struct = np.zeros((), layouts.SILHOUETTE_VIEW)
    struct["eye"] = eye / (np.abs(eye).max() or 1.0)  # zero if the eye sees all the model as one line
    struct["n_candidates"] = n_candidates
    struct["keeps_others"] = keeps_others
    pipeline = device.pipelines.compute("extract_silhouette", workgroup_size=choose_workgroup_size(device))
    with device.lock:
        (view,) = uniforms.upload(device, "silhouette", "view", [struct])
        with device.encode_commands(view.buffer, candidates, planes, edges, label="silhouette") as encoder:
            bindings = device.bind_groups.bind(pipeline, view=view, candidates=candidates, planes=planes, edges=edges)
            dispatch(encoder, pipeline, bindings, count_workgroups(device, n_candidates))
    return edges
