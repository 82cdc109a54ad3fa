"""What reports say of a whole run."""

import datetime
import time
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

from ... import __version__
from ..exit_codes import FAILURES
from ..outcome import Outcome, Status
from ..references import find_threshold

if TYPE_CHECKING:
    from ...device import Device


@dataclass(frozen=True)
class RunFacts:
    """What reports say of a whole run.

    adapter : the name and the driver of the adapter that drew; "none" if there was none
    threshold : of comparisons, None if there was none
    unused : paths of references that are of no model
    began : when the run began, in ISO 8601
    """

    adapter: str
    threshold: float | None
    unused: Sequence[str]
    exit_code: int
    time_s: float
    began: str
    version: str = __version__

    @classmethod
    def of(
        cls,
        options: Namespace,
        open_device: "Callable[[], Device]",
        unused: Sequence[str],
        exit_code: int,
        start: float,
    ) -> "RunFacts":
        """Return the facts of a run that began at `start` seconds of the clock `time.perf_counter`, and is over now."""
        try:
            adapter = open_device().adapter
            name = f"{adapter.name}, {adapter.driver}"
        except FAILURES:
            name = "none"
        time_s = time.perf_counter() - start
        began = datetime.datetime.now(datetime.UTC) - datetime.timedelta(seconds=time_s)
        return cls(
            name,
            None if options.reference is None else find_threshold(options),
            unused,
            exit_code,
            time_s,
            began.isoformat(timespec="seconds"),
        )


def count_statuses(outcomes: Sequence[Outcome]) -> dict[Status, int]:
    """Return how many pictures have each status that occurs, in the order of `Status`."""
    counts = Counter(outcome.status for outcome in outcomes)
    return {status: counts[status] for status in get_args(Status) if counts[status]}
