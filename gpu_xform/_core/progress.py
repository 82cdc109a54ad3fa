"""A progress bar for what lasts more than a second, on a terminal only."""

import contextlib
import os
import shutil
import sys
from collections.abc import Callable, Iterator

DELAY_S = 1.0


@contextlib.contextmanager
def show_progress(label: str, unit: str, *, scaled: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Give a function of what is done and of the whole that moves a bar on standard error; `scaled` writes 5k, 8M."""
    from tqdm import tqdm

    silent = sys.stderr is None or not sys.stderr.isatty()
    width, height = (None, None) if silent else _assume_size()
    with tqdm(
        desc=label,
        unit=unit,
        unit_scale=scaled,
        delay=DELAY_S,
        disable=silent,
        leave=False,
        ncols=width,
        nrows=height,
        dynamic_ncols=width is None,
    ) as shown:

        def move(done: int, whole: int) -> None:
            shown.total = whole
            shown.update(done - shown.n)

        yield move


def _assume_size() -> tuple[int | None, int | None]:
    """Return how many columns and rows to take for those of a terminal that says 0 of either; None if it knows them."""
    with contextlib.suppress(OSError, AttributeError):  # of what is no file of the system
        columns, rows = os.get_terminal_size(sys.stderr.fileno())
        if columns == 0 or rows == 0:
            usual = shutil.get_terminal_size()
            return (columns or usual.columns) - 1, rows or usual.lines  # as tqdm does: the last may begin a new line
    return None, None


def write_lines(text: str) -> None:
    """Write whole lines to standard error; a bar makes way for them."""
    from tqdm import tqdm

    tqdm.write(text, file=sys.stderr, end="")
