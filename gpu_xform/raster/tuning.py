"""Tunings: how long both rasterisers took on an adapter, kept in a file, and which of them is the faster by it."""

import json
import math
import os
import sys
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from .._core.atomic_files import atomic_write
from ..device import Adapter
from .workload import Workload

VARIABLE = "GPU_XFORM_TUNING"
FILE_NAME = "rasterizers.json"
FORMAT = 1
MIN_RATIO_FOR_COMPUTE = 1.2  # of the time of the render pass to that of compute shaders


class TunedCell(NamedTuple):
    """What a picture of `n_edges` edges of `length_px` pixels each took, in milliseconds."""

    n_edges: int
    length_px: float
    render_ms: float
    compute_ms: float

    @property
    def prefers_compute(self) -> bool:
        """Whether compute shaders were faster by so much that they are chosen."""
        return self.render_ms > MIN_RATIO_FOR_COMPUTE * self.compute_ms


def nearest_cell(cells: Sequence[TunedCell], workload: Workload) -> TunedCell:
    """Return the cell that is nearest to a workload, by the ratios of the numbers of edges and of the lengths."""

    def distance(cell: TunedCell) -> float:
        edges = math.log(max(workload.n_edges, 1) / cell.n_edges)
        return math.hypot(edges, math.log(max(workload.length_px, 1.0) / cell.length_px))

    return min(cells, key=distance)


def tuning_path() -> Path:
    """Return the file of GPU_XFORM_TUNING, or the one in the user's cache folder; raise OSError if there is none."""
    if os.environ.get(VARIABLE):
        return Path(os.environ[VARIABLE])
    if sys.platform == "win32":
        folder = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        folder = "~/Library/Caches"
    else:
        folder = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    try:
        return Path(folder).expanduser() / "gpu_xform" / FILE_NAME
    except RuntimeError as error:
        raise FileNotFoundError(f"the user has no home folder, and {VARIABLE} is not set") from error


def load_tuning(adapter: Adapter) -> tuple[TunedCell, ...]:
    """Return what was measured on an adapter with its present driver; nothing if the file is missing or damaged."""
    try:
        path = tuning_path()
        modified = path.stat().st_mtime_ns
    except (OSError, ValueError):
        return ()
    return _read(path, modified).get(_key(adapter), ())


def save_tuning(adapter: Adapter, cells: Sequence[TunedCell]) -> Path:
    """Keep what was measured on an adapter, beside that of others; return the file. Raises OSError."""
    path = tuning_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    known = _read(path, path.stat().st_mtime_ns) if path.is_file() else {}
    adapters = {**known, _key(adapter): tuple(cells)}
    content = {"format": FORMAT, "adapters": {key: [cell._asdict() for cell in own] for key, own in adapters.items()}}
    with atomic_write(path) as file:
        file.write(json.dumps(content, indent=1).encode())
    _read.cache_clear()  # of a file that is written twice within the resolution of its time
    return path


@lru_cache(maxsize=4)
def _read(path: Path, _modified_ns: int) -> Mapping[str, tuple[TunedCell, ...]]:
    """Return the cells of each adapter; none of a file that is not as `save_tuning` writes it."""
    try:
        content = json.loads(path.read_bytes())
        if content["format"] != FORMAT:
            return {}
        return {key: tuple(map(_parse_cell, cells)) for key, cells in content["adapters"].items()}
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def _parse_cell(fields: Mapping[str, Any]) -> TunedCell:
    """Return a cell of positive, finite numbers; raise ValueError, TypeError or KeyError for what is none."""
    n_edges, *measured = (float(fields[name]) for name in TunedCell._fields)
    if not all(0.0 < value < math.inf for value in (n_edges, *measured)):
        raise ValueError(f"not a measurement: {fields}")
    return TunedCell(max(int(n_edges), 1), *measured)


def _key(adapter: Adapter) -> str:
    return f"{adapter.name} | {adapter.backend} | {adapter.driver}"
