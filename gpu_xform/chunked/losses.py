"""What a target cannot hold of chunked points, in words for warnings."""

from collections.abc import Collection

from ..formats._warn import warn

_NAMES = {"npy": "NPY", "zarr": "a Zarr array", "las": "LAS", "laz": "LAZ", "ply": "PLY"}
_MAX_NAMED = 24


def warn_of_losses(destination: str, file_type: str, lost: Collection[str], records: Collection[str] = ()) -> None:
    """Issue one MeshWarning of what the target cannot hold, if there is anything.

    lost : fields of points
    records : what belongs to the whole cloud
    """
    parts = []
    if lost:
        named = list(lost)[:_MAX_NAMED]
        more = f", and {len(lost) - _MAX_NAMED} more" if len(lost) > _MAX_NAMED else ""
        parts.append(f"{', '.join(named)} per point{more}")
    parts += records
    if parts:
        warn(f"{destination}: {_NAMES[file_type]} does not hold {'; '.join(parts)}")
