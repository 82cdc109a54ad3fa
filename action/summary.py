"""The summary of a job in Markdown, and the pictures that it shows, from a JSON report of `gpu-xform render`.

summary.py stage REPORT FOLDER
    copies the pictures that someone should look at into a folder
summary.py write REPORT REPOSITORY_URL PUBLISHED_URL ARTIFACT_URL
    prints the summary; either of the last two may be empty

GitHub shows neither data URIs nor files of artifacts in a summary, but images that have an address: committed
references at the commit of the run, and the others where the action has published them.
"""

import json
import shutil
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import quote

MAX_ROWS = 60  # GitHub shows a megabyte of a summary
GOOD = ("matched", "drawn")
WORDS = {
    "failed": "not drawn",
    "differs": "different from the reference",
    "no reference": "without a reference",
    "updated": "reference updated",
    "added": "reference added",
    "matched": "as expected",
    "drawn": "drawn",
}
COLUMNS = {"reference": "expected", "picture": "actual", "difference": "difference"}


def main() -> None:
    """Run the command that the process was started with."""
    command, report_path, *rest = sys.argv[1:]
    report = json.loads(Path(report_path).read_bytes())
    if command == "stage":
        stage(report, Path(rest[0]))
    else:
        sys.stdout.reconfigure(encoding="utf-8", errors="backslashreplace")  # type: ignore[union-attr]
        sys.stdout.write("\n".join(format_summary(report, *rest)) + "\n")


def stage(report: dict[str, Any], folder: Path) -> None:
    """Copy what was drawn, and its difference, of pictures that are not as expected."""
    for i, record in list_bad(report):
        for name in ("picture", "difference"):
            path = record[name]
            if path is not None and Path(path).is_file():
                shutil.copyfile(path, folder / f"{i}-{name}.png")


def list_bad(report: dict[str, Any]) -> list[tuple[int, dict[str, Any]]]:
    """Return the first pictures that are not as expected, each with its place in the report."""
    return [(i, record) for i, record in enumerate(report["pictures"]) if record["status"] not in GOOD][:MAX_ROWS]


def format_summary(report: dict[str, Any], repository: str, published: str, artifact: str) -> Iterator[str]:
    """Yield the lines of the summary."""
    counts = ", ".join(f"{n} {WORDS[status]}" for status, n in report["counts"].items())
    yield f"## {':x:' if report['exit_code'] else ':white_check_mark:'} Pictures of models: {counts}"
    yield ""
    if artifact:
        yield f"[All pictures, and a report to look at]({artifact}), drawn by {escape(report['adapter'])}"
        yield ""
    bad = list_bad(report)
    if bad:
        yield "<table><tr><th>model</th>" + "".join(f"<th>{title}</th>" for title in COLUMNS.values()) + "</tr>"
        for i, record in bad:
            yield format_row(i, record, repository, published, artifact)
        yield "</table>"
        yield ""
    n_bad = sum(record["status"] not in GOOD for record in report["pictures"])
    if n_bad > len(bad):
        yield f"{n_bad - len(bad)} more are in the report."
        yield ""
    if report["unused_references"]:
        names = [f"<code>{escape(path)}</code>" for path in report["unused_references"]]
        yield "References of no model: " + ", ".join(names)
        yield ""
    good = [record for record in report["pictures"] if record["status"] in GOOD]
    if good:
        yield f"<details><summary>{len(good)} as expected</summary>"
        yield "".join(format_good(record, repository) for record in good[:MAX_ROWS])
        yield "</details>"


def format_row(i: int, record: dict[str, Any], repository: str, published: str, artifact: str) -> str:
    """Return the row of a picture that is not as expected: its name, what is wrong, and thumbnails."""
    images = {"reference": format_reference(record, repository, 200)}
    for name in ("picture", "difference"):
        has_one = record[name] is not None and record["status"] != "failed" and Path(record[name]).is_file()
        elsewhere = f'<a href="{escape(artifact)}">in the artifact</a>' if artifact and has_one else ""
        is_shown = published and has_one
        images[name] = f'<img width="200" src="{escape(published)}/{i}-{name}.png">' if is_shown else elsewhere
    words = escape(record["message"] or WORDS[record["status"]])
    cells = "".join(f"<td>{images[name]}</td>" for name in COLUMNS)
    return f"<tr><td><b>{format_name(record)}</b><br>{words}</td>{cells}</tr>"


def format_good(record: dict[str, Any], repository: str) -> str:
    """Return the thumbnail of a picture that is as expected, which is its reference, or its name alone."""
    return format_reference(record, repository, 96) or f"<code>{format_name(record)}</code> "


def format_reference(record: dict[str, Any], repository: str, width: int) -> str:
    """Return the thumbnail of a reference, if it is in the repository."""
    path = PurePosixPath(record["reference"] or "")
    if path.is_absolute() or ".." in path.parts or not Path(path).is_file():
        return ""
    address = f"{repository}/{quote(str(path), errors='surrogateescape')}"
    return f'<img width="{width}" alt="{format_name(record)}" title="{format_name(record)}" src="{escape(address)}">'


def format_name(record: dict[str, Any]) -> str:
    """Return the name of a picture."""
    return escape(", ".join(record["models"]))


if __name__ == "__main__":
    main()
