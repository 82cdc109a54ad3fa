"""Side-by-side timing: contenders take turns, round after round, so that noise of the machine affects all equally.

Each round begins with another of them: who follows whom matters, since the disk still writes what the last one left.
"""

import gc
import os
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

Contender = Callable[[], object]

# The worker threads of OpenBLAS and OpenMP spin on for tens of milliseconds after their work, and the next contender
# would pay for it. Both read these when they are loaded.
CALM_THREADS = {"OPENBLAS_THREAD_TIMEOUT": "4", "OMP_WAIT_POLICY": "PASSIVE"}
# What makes OpenBLAS choose kernels for another processor than it finds: NumPy is timed as it comes.
FOREIGN_TUNING = {"OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"}


def calm_threads() -> None:
    """Start the script anew with threads that sleep as soon as they have nothing to do, and with OpenBLAS as it comes.

    If it is so already, do nothing.
    """
    if CALM_THREADS.items() <= os.environ.items() and not FOREIGN_TUNING & os.environ.keys():
        return
    kept = {name: value for name, value in os.environ.items() if name not in FOREIGN_TUNING}
    os.execve(sys.executable, [sys.executable, *sys.argv], kept | CALM_THREADS)  # noqa: S606


@dataclass(frozen=True)
class Row:
    """One line of a table: what was timed, against what, their medians in seconds, and the ratio asked for.

    floor : seconds of the same on our side with shaders that copy and compute nothing
    """

    what: str
    against: str
    ours: float
    theirs: float
    at_most: float | None = None
    floor: float | None = None

    @property
    def ratio(self) -> float:
        """Our median over theirs."""
        return self.ours / self.theirs


def medians(contenders: Mapping[str, Contender], rounds: int = 9, warm_up: int = 2) -> dict[str, float]:
    """Return the median seconds of each contender over `rounds` interleaved rounds, after `warm_up` uncounted ones."""
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    gc.disable()
    try:
        for turn in range(warm_up + rounds):
            first = turn % len(contenders)
            for name in [*contenders][first:] + [*contenders][:first]:
                start = time.perf_counter()
                contenders[name]()
                if turn >= warm_up:
                    seconds[name].append(time.perf_counter() - start)
    finally:
        gc.enable()
    return {name: statistics.median(values) for name, values in seconds.items()}


def table(rows: list[Row]) -> str:
    """Return the rows as a Markdown table, ratios rather than bare times first."""
    lines = ["| what | against | ratio | asked | floor | ours, ms | theirs, ms |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        asked = "" if row.at_most is None else f"≤ {row.at_most:g}"
        met = "" if row.at_most is None or row.ratio <= row.at_most else " **missed**"
        floor = "" if row.floor is None else f"{row.floor / row.theirs:.2f}"
        lines.append(
            f"| {row.what} | {row.against} | {row.ratio:.2f}{met} | {asked} | {floor} "
            f"| {1e3 * row.ours:.3g} | {1e3 * row.theirs:.3g} |"
        )
    return "\n".join(lines)
