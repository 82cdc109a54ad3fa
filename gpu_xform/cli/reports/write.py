"""Reports written to files, in the format that the name of each ends in."""

from collections.abc import Callable, Sequence

from .. import files
from ..outcome import Outcome
from ..paths import file_type
from .html_report import format_html
from .json_report import format_json
from .junit_report import format_junit
from .run_facts import RunFacts

FORMATTERS: dict[str, Callable[[Sequence[Outcome], RunFacts], bytes]] = {
    "html": format_html,
    "json": format_json,
    "xml": format_junit,
}


def write_reports(paths: Sequence[str], outcomes: Sequence[Outcome], facts: RunFacts) -> None:
    """Write a report to each path; missing folders are made."""
    for path in paths:
        files.write_picture(FORMATTERS[file_type(path)](outcomes, facts), path, make_folders=True)
