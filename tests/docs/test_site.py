"""How the pages of the site come about; `make test-docs` looks at the site itself."""

import re
from pathlib import Path
from typing import Any

import nbformat
import pytest

from docs.builder import check, command, gallery, links, notebook, options, pages, reference
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
    assert links.rewrite_page(f"[`it`]({target})", "docs/a.md", PLACES) == f"[`it`]({expected})"
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


def test_each_option_of_render_has_two_pictures_or_a_reason() -> None:
    [render] = [each for each in command.describe_commands() if each.name == "render"]
    typed = {option.typed for _, group in render.groups for option in group if option.typed.startswith("-")}
    names = {words.split()[0] if words.startswith("--") else words.split()[1] for words in typed}
    shown = set(options.PLAIN) | set(options.UNSEEN)
    assert names == shown, "docs/builder/options.py lacks a line for an option, or has one for none"
    for option, (_, addition) in options.PLAIN.items():
        assert addition.split()[0] == option


def test_there_are_two_dozen_scripts_of_pictures_each_with_its_words() -> None:
    scripts = sorted(gallery.SCRIPTS.glob("*.py"))
    assert len(scripts) >= 24
    assert set(gallery.FIRST) <= {script.stem for script in scripts}
    titles = [gallery.read_script(script)[0] for script in scripts]
    assert len(set(titles)) == len(titles)
    for script in scripts:
        assert re.search(rf'"{script.stem}\.(png|webp|svg)"', script.read_text("utf-8")), script.name


def test_the_manual_page_has_every_option_of_every_command() -> None:
    page = command.format_man_page()
    for each in command.describe_commands():
        assert f'.SH "GPU-XFORM {each.name.upper()}"' in page
        for _, group in each.groups:
            for option in group:
                assert f".B {command._roff(option.typed)}\n" in page
    requests = {line.split()[0] for line in page.splitlines() if line.startswith((".", "'"))}
    assert requests == {".TH", ".SH", ".B", ".TP", ".PP", ".SS", ".nf", ".fi"}


def test_links_within_the_notebook_are_those_of_the_site() -> None:
    listed = "[1](#1.-From-surfaces-to-polygons), [10](#10.-Instances,-and-parts)"
    assert notebook.rename_anchors(listed) == "[1](#1-from-surfaces-to-polygons), [10](#10-instances-and-parts)"


def test_a_figure_that_is_too_large_stops_the_build() -> None:
    book: Any = nbformat.v4
    cell = book.new_code_cell("draw()")
    cell.outputs = [book.new_output("display_data", {"text/html": "x" * 1_000_001})]
    with pytest.raises(ValueError, match=r"a figure of 1,000,001 bytes"):
        notebook.require_small_figures(book.new_notebook(cells=[cell]))


def test_pages_of_modules_have_no_reading_order() -> None:
    lines = ["Matrices.", "", "More.", "", "Reading order: a,", "b.", ""]
    assert [line for line in reference.drop_reading_order(lines) if line] == ["Matrices.", "More."]
