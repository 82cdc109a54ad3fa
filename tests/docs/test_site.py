"""How the pages of the site come about; `make test-docs` looks at the site itself."""

from pathlib import Path

import pytest

from docs.builder import check, links, pages
from docs.builder.project import REPOSITORY

ROOT = Path(__file__).parents[2]
PLACES = {"docs/a.md": "guides/a.md", "docs/b.md": "project/b.md", "README.md": "index.md"}


@pytest.mark.parametrize(
    ("target", "expected"),
    [
        ("b.md", "../project/b.md"),
        ("b.md#section", "../project/b.md#section"),
        ("../README.md", "../index.md"),
        ("#here", "#here"),
        ("https://example.org/x", "https://example.org/x"),
        ("images/hills.png", "../images/hills.png"),
        ("../Makefile", f"{REPOSITORY}/blob/main/Makefile"),
        ("../benchmarks/", f"{REPOSITORY}/tree/main/benchmarks"),
    ],
)
def test_a_link_leads_to_the_same_thing_on_the_site(target: str, expected: str) -> None:
    assert links.rewrite_link(target, "docs/a.md", PLACES) == expected
    page = f"see [it]({target}), `[x]({target})`\n\n```sh\n[y]({target})\n```\n"
    assert links.rewrite_page(page, "docs/a.md", PLACES).startswith(f"see [it]({expected})")
    assert links.rewrite_page(page, "docs/a.md", PLACES).endswith(f"[y]({target})\n```\n")


def test_a_link_that_leads_nowhere_stops_the_build() -> None:
    with pytest.raises(FileNotFoundError, match=r"docs/a\.md: a link leads nowhere: missing\.md"):
        links.rewrite_link("missing.md", "docs/a.md", PLACES)


def test_centred_pictures_become_pictures_of_the_page() -> None:
    page = '<p align="center"><img src="images/hills.png" width="720"\nalt="Two\nhills"></p>'
    shown = links.rewrite_page(page, "docs/a.md", PLACES)
    assert shown == "![Two hills](../images/hills.png){width=720px align=center}"


def test_every_page_of_the_repository_has_a_place_of_its_own() -> None:
    places = pages.place_pages()
    written = {path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md")}
    assert written | {path.name for path in ROOT.glob("*.md")} <= set(places)
    assert len(set(places.values())) == len(places)


def test_broken_links_of_finished_pages_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<p id="x"><a href="b.html#y"></a><a href="#x"></a><img src="no.png">')
    (tmp_path / "b.html").write_text('<p id="z"><a href="a.html#x"></a><a href="https://example.org"></a>')
    assert check.find_broken_links(tmp_path) == [
        "a.html: b.html#y leads to no place of the page",
        "a.html: no.png leads to no file",
    ]
