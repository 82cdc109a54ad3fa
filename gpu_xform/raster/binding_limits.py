"""Drawables split by their instances, so that what is computed of each fits in one storage-buffer binding."""

from collections.abc import Iterator
from dataclasses import replace

from ..drawing.draw_list import Drawable
from ..drawing.limits import CLIP_POSITION_BYTES
from ..gpu.chunking import align_points
from ..gpu.device import GpuDevice
from .triangles import HEAD_BYTES, INDEX_BYTES


def split_to_binding_limits(device: GpuDevice, drawable: Drawable) -> Iterator[Drawable]:
    """Split a drawable into as many as bindings need: for its clip positions, and a number per face or per edge."""
    n_triangles = drawable.faces.n_triangles if drawable.faces else 0
    n_numbers = max(n_triangles, *(lines.n_edges for lines in drawable.lines), 0)
    instance_bytes = max(align_points(drawable.points.n_points) * CLIP_POSITION_BYTES, n_numbers * INDEX_BYTES)
    max_bytes = device.limits.max_bound_bytes - HEAD_BYTES
    max_instances = max(1, min(max_bytes // instance_bytes, device.limits.max_workgroups))
    if len(drawable.clip_from_points) <= max_instances:
        yield drawable
        return
    for start in range(0, len(drawable.clip_from_points), max_instances):
        yield replace(drawable, clip_from_points=drawable.clip_from_points[start : start + max_instances])
