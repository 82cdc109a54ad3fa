"""The choice between compiled loops and NumPy."""

import warnings
from collections.abc import Callable, Iterable
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.interrupts import defer_interrupts
from ...errors import DeviceWarning, GpuXformError

# Fewer points take NumPy less time than numba takes to start its threads, and much less than to import it: through
# matrices of their own and for bounds, through one matrix, and through a stack.
MIN_COMPILED_POINTS = 4096
MIN_COMPILED_PRODUCTS = 16384
MIN_COMPILED_MATRICES = 64
POINTS_PER_BLOCK = 16384  # of compiled loops: more work than handing out a task is, and a part of a processor's cache

Array = npt.NDArray[Any]

_has_failed = False


def run_loop(name: str, inputs: Iterable[Array], out: Array, *options: Any) -> bool:
    """Run a compiled loop of `loops.py`; return False if numba is not installed, or fails, of which a warning tells.

    inputs : arrays that the loop reads, the points first
    options : what comes after where the blocks of points begin
    """
    points, *tables = inputs
    return run_loop_in_blocks(name, (points, *tables), out, find_block_starts(len(points)), *options)


def run_loop_in_blocks(name: str, inputs: Iterable[Array], out: Array, starts: Array, *options: Any) -> bool:
    """Run a compiled loop of `loops.py` as `run_loop` does, in blocks that begin at `starts`."""
    return run_compiled(_import_loops, name, *(as_constant(array) for array in inputs), out, starts, *options)


def run_compiled(import_loops: Callable[[], ModuleType | None], name: str, *arguments: Any) -> bool:
    """Run a loop of a module; return False if numba is not installed, or fails, of which a warning tells.

    import_loops : returns the module, None without numba
    """
    global _has_failed
    if _has_failed:
        return False
    try:
        loops = import_loops()
        if loops is None:
            return False
        getattr(loops, name)(*arguments)
    except GpuXformError:
        raise
    except Exception as error:  # numba raises what its many parts raise
        _has_failed = True
        reason = str(error).strip().partition("\n")[0]
        warnings.warn(
            f"numba failed, so the host device computes by NumPy from now on: {type(error).__name__}: {reason}",
            DeviceWarning,
            stacklevel=2,
        )
        return False
    return True


def find_block_starts(n_points: int) -> npt.NDArray[np.int64]:
    """Return where each block begins, and `n_points`: the same for any number of threads."""
    return np.append(np.arange(0, n_points, POINTS_PER_BLOCK), n_points)


def as_constant(array: Array) -> Array:
    """Return a read-only view: numba compiles once for arrays that may be written and for those that may not."""
    view = array.view(np.ndarray)
    view.flags.writeable = False
    return view


@cache
def _import_loops() -> ModuleType | None:
    try:
        with defer_interrupts():
            from . import loops
    except ModuleNotFoundError as error:
        if error.name != "numba":
            raise
        return None
    return loops
