"""Progress bars on a terminal, for work that lasts more than a second."""

import contextlib
import os
import shutil
import sys
from collections.abc import Callable, Iterator

from .printable import escape_line

DELAY_S = 1.0


@contextlib.contextmanager
def show_progress(label: str, unit: str, *, scaled: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Yield a function of (done, total) that updates a bar on standard error.

    scaled : write 5k and 8M instead of 5000 and 8000000
    """
    from tqdm import tqdm

    silent = sys.stderr is None or not sys.stderr.isatty()
    width, height = (None, None) if silent else _assume_size()
    with tqdm(
        desc=escape_line(label),
        unit=unit,
        unit_scale=scaled,
        delay=DELAY_S,
        disable=silent,
        leave=False,
        ncols=width,
        nrows=height,
        dynamic_ncols=width is None,
    ) as bar:

        def update(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield update


def _assume_size() -> tuple[int | None, int | None]:
    """Return the columns and rows to assume for a terminal that reports 0 of either; None if it reports both."""
    with contextlib.suppress(OSError, AttributeError):  # standard error may be no file of the system
        columns, rows = os.get_terminal_size(sys.stderr.fileno())
        if columns == 0 or rows == 0:
            fallback = shutil.get_terminal_size()
            return (columns or fallback.columns) - 1, rows or fallback.lines  # tqdm leaves the last column free too
    return None, None


def write_line(text: str) -> None:
    """Write a line to standard error, above a progress bar if there is one."""
    from tqdm import tqdm

    if sys.stderr is not None:
        tqdm.write(escape_line(text), file=sys.stderr)
