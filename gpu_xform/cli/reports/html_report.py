"""HTML report: one page without links to other files, what failed first, each beside what was expected."""

from collections.abc import Iterator, Sequence
from html import escape
from importlib.resources import files

from ..._core.printable import escape_controls
from ..outcome import Outcome, Status
from .run_facts import RunFacts, count_statuses

SUMMARY, PICTURES, FACTS = "<!-- summary -->", "<!-- pictures -->", "<!-- facts -->"
TITLES: dict[Status, str] = {
    "failed": "Not drawn",
    "differs": "Different from the reference",
    "no reference": "Without a reference",
    "updated": "References updated",
    "added": "References added",
    "matched": "As expected",
    "drawn": "Drawn",
}
CAPTIONS = {"reference": "expected", "picture": "actual", "difference": "difference"}
LARGE: tuple[Status, ...] = ("failed", "differs", "no reference", "updated", "added")


def format_html(outcomes: Sequence[Outcome], facts: RunFacts) -> bytes:
    """Return the report as a page."""
    page = files(__package__).joinpath("report.html").read_text("utf-8")
    counts = count_statuses(outcomes)
    parts = {
        SUMMARY: _format_summary(counts, facts),
        PICTURES: "\n".join(_format_sections(outcomes, counts, facts)),
        FACTS: _format_facts(facts),
    }
    for slot, content in parts.items():
        before, after = page.split(slot)
        page = before + content + after
    return page.encode()


def _format_summary(counts: dict[Status, int], facts: RunFacts) -> str:
    n_pictures = sum(counts.values())
    if facts.exit_code:
        n_bad = sum(counts.get(status, 0) for status in ("failed", "differs", "no reference"))
        verdict, mark = f"{n_bad} of {n_pictures} need{'s' * (n_bad == 1)} a look", "bad"
    else:
        n_written = counts.get("updated", 0) + counts.get("added", 0)
        verdict, mark = f"{n_pictures} picture{'s' * (n_pictures != 1)}", "good"
        if n_written:
            verdict, mark = f"{verdict}, {n_written} new reference{'s' * (n_written != 1)} to look at", "new"
        elif "matched" in counts:
            verdict += ", nothing to look at"
    chips = [
        f'<a class="chip {_anchor(status)}" href="#{_anchor(status)}"><b>{n}</b> {_count_words(status, n)}</a>'
        for status, n in counts.items()
    ]
    if facts.unused:
        chips.append(f'<a class="chip unused" href="#unused"><b>{len(facts.unused)}</b> of no model</a>')
    return f'<h1 class="{mark}">{verdict}</h1>\n<nav>{"".join(chips)}</nav>'


def _format_sections(outcomes: Sequence[Outcome], counts: dict[Status, int], facts: RunFacts) -> Iterator[str]:
    for status in counts:
        chosen = [outcome for outcome in outcomes if outcome.status == status]
        size = "large" if status in LARGE else "small"
        yield f'<section id="{_anchor(status)}" class="{size}"><h2>{TITLES[status]} <span>{len(chosen)}</span></h2>'
        yield from (_format_outcome(outcome) for outcome in chosen)
        yield "</section>"
    if facts.unused:
        yield f'<section id="unused"><h2>References of no model <span>{len(facts.unused)}</span></h2><ul>'
        yield from (f"<li>{_text(path)}</li>" for path in facts.unused)
        yield "</ul></section>"


def _format_outcome(outcome: Outcome) -> str:
    return (_format_large if outcome.status in LARGE else _format_small)(outcome)


def _format_large(outcome: Outcome) -> str:
    """Return the pictures of an outcome side by side, under its name, what is wrong, and its numbers."""
    figures = "".join(
        f"<figure>{_format_image(outcome, name)}<figcaption>{caption}</figcaption></figure>"
        for name, caption in CAPTIONS.items()
        if name in outcome.embedded
    )
    layout = "figures" if len(outcome.embedded) > 1 else "figure"
    message = f'<p class="message">{_text(outcome.message)}</p>' if outcome.message else ""
    numbers = ""
    if outcome.numbers is not None:
        x, y = outcome.numbers.largest_at
        terms = {
            "pixels": f"{outcome.numbers.n_pixels:,}, {outcome.numbers.n_allowed:,} allowed",
            "largest": f"{outcome.numbers.largest} of 255 at {x},{y}",
            "mean": f"{outcome.numbers.mean:.3g}",
        }
        numbers = "".join(f"<dt>{term}</dt><dd>{value}</dd>" for term, value in terms.items())
    return (
        f'<article class="{_anchor(outcome.status)}"><h3>{_breakable(outcome.picture.name)}</h3>{message}'
        f'<div class="{layout}">{figures}</div><dl>{numbers}<dt>time</dt><dd>{outcome.time_s:.2f} s</dd></dl></article>'
    )


def _format_small(outcome: Outcome) -> str:
    """Return the thumbnail of an outcome with its name below."""
    name, time = _breakable(outcome.picture.name), f"{outcome.time_s:.2f} s"
    return f"<figure>{_format_image(outcome, 'picture')}<figcaption>{name} <span>{time}</span></figcaption></figure>"


def _format_image(outcome: Outcome, name: str) -> str:
    if name not in outcome.embedded:
        return '<div class="none">no picture</div>'
    title = f"{CAPTIONS[name]}: {outcome.picture.name}"
    return f'<img loading="lazy" alt="{_text(title)}" src="{outcome.embedded[name]}">'


def _format_facts(facts: RunFacts) -> str:
    terms = {
        "gpu_xform": facts.version,
        "drawn by": facts.adapter,
        "began": facts.began,
        "took": f"{facts.time_s:.1f} s",
        "exit code": str(facts.exit_code),
    }
    if facts.threshold is not None:
        terms["threshold"] = f"{facts.threshold:g} of 255"
    return "".join(f"<dt>{term}</dt><dd>{_text(value)}</dd>" for term, value in terms.items())


def _count_words(status: Status, n: int) -> str:
    """Return what stands behind a number of pictures of a status."""
    words = TITLES[status].lower()
    return words.replace("references", "reference", 1) if n == 1 else words


def _anchor(status: Status) -> str:
    return status.replace(" ", "-")


def _breakable(path: str) -> str:
    """Return a path for a page, where lines may end behind its folders."""
    return _text(path).replace("/", "/<wbr>")


def _text(text: str) -> str:
    """Return a text for a page: no control characters, and escapes for bytes of names that are no UTF-8."""
    return escape(escape_controls(text).encode("utf-8", "backslashreplace").decode())
