"""What a target cannot hold of chunked points, in words for warnings."""

from collections.abc import Collection

from ..formats._warn import warn

_NAMES = {"npy": "NPY", "zarr": "a Zarr array", "las": "LAS", "laz": "LAZ", "ply": "PLY"}
_MAX_NAMED = 24


def warn_of_losses(destination: str, file_type: str, lost: Collection[str]) -> None:
    """Issue one MeshWarning that names fields of points which the target cannot hold, if there are any."""
    if lost:
        named = list(lost)[:_MAX_NAMED]
        more = f", and {len(lost) - _MAX_NAMED} more" if len(lost) > _MAX_NAMED else ""
        warn(f"{destination}: {_NAMES[file_type]} does not hold {', '.join(named)} per point{more}")
