"""The pages of the repository on the site, and its contents: each section's page lists those of its pages."""

import re
from pathlib import Path
from typing import NamedTuple

from .links import rewrite_page
from .project import ROOT

# Pages outside docs/, and those of docs/ that stand in a section of their own; every other page of docs/ is a guide.
PROJECT_PAGES = {
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "ARCHITECTURE.md": "project/architecture.md",
    "SECURITY.md": "project/security.md",
    "benchmarks/README.md": "project/benchmarks.md",
    "docs/reliability.md": "project/reliability.md",
    "packaging/README.md": "project/releasing.md",
}
START = "docs/start.md"
REFERENCE_PAGES = {"docs/api.md": "reference/index.md", "docs/conventions.md": "reference/conventions.md"}
HOME = {"README.md": "index.md"}


class Section(NamedTuple):
    """A part of the site: a page with a title and some words, which lists other pages."""

    folder: str
    title: str
    words: str
    pages: tuple[str, ...]


def place_pages() -> dict[str, str]:
    """Return where on the site each Markdown page of the repository stands; a new page of docs/ is a guide."""
    places = HOME | PROJECT_PAGES | REFERENCE_PAGES | {START: "start.md"}
    for page in sorted((ROOT / "docs").glob("*.md")):
        places.setdefault(f"docs/{page.name}", f"guides/{page.name}")
    places["docs/lecture.ipynb"] = "tutorials/lecture.ipynb"
    for page in sorted((ROOT / "docs" / "tutorials").glob("*.md")):
        places[f"docs/tutorials/{page.name}"] = f"tutorials/{page.name}"
    return {page: place for page, place in places.items() if (ROOT / page).exists()}


def write_pages(source: Path) -> None:
    """Write all pages of the repository but the README, which the site's own start replaces, into `source`."""
    places = place_pages()
    for page, place in places.items():
        if page not in HOME and page.endswith(".md"):
            write(source / place, rewrite_page((ROOT / page).read_text("utf-8"), page, places))


def write_section(source: Path, section: Section) -> None:
    """Write the page of a section."""
    pages = "\n".join(section.pages)
    write(
        source / section.folder / "index.md",
        f"# {section.title}\n\n{section.words}\n\n```{{toctree}}\n:maxdepth: 1\n\n{pages}\n```\n",
    )


def title_of(page: Path) -> str:
    """Return the first title of a Markdown page."""
    found = re.search(r"^# (.+)$", page.read_text("utf-8"), re.MULTILINE)
    if found is None:
        raise ValueError(f"{page} has no title")
    return found[1]


def write(path: Path, text: str) -> None:
    """Write a page, and its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")
