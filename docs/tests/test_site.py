"""The finished site in a browser: `make test-docs` builds it, and runs this."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.browser import Browser

SITE = Path(__file__).parents[2] / "build" / "site" / "html"
PAGES = sorted(
    path.relative_to(SITE).as_posix() for path in SITE.rglob("*.html") if "_static" not in path.relative_to(SITE).parts
)
DESKTOP, PHONE = (1280, 900), (390, 844)
BROKEN = "[...document.images].filter(image => image.complete && !image.naturalWidth).map(image => image.src)"
LOADED = "[...document.images].every(image => image.loading === 'lazy' || image.complete)"


@pytest.fixture(scope="module")
def opened() -> Iterator[Browser]:
    with Browser() as browser:
        yield browser


def test_there_is_a_site() -> None:
    assert {"index.html", "search.html", "reference/index.html"} <= set(PAGES)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_no_errors_and_fits(page: str, opened: Browser) -> None:
    for size in (DESKTOP, PHONE):
        opened.open(SITE / page, size)
        opened.wait_for(LOADED)
        assert opened.console_messages() == []
        assert opened.evaluate(BROKEN) == []
        assert opened.evaluate("document.documentElement.scrollWidth") <= size[0], size
        assert opened.evaluate("document.querySelector('h1').innerText.length") > 0
        assert opened.evaluate("document.querySelectorAll('.search-button, .search-button-field').length") > 0
        assert "_NestedSequence" not in opened.evaluate("document.body.innerText")  # of NumPy's types


def test_the_search_knows_each_public_name() -> None:
    import gpu_xform

    index = json.loads((SITE / "searchindex.js").read_text("utf-8").removeprefix("Search.setIndex(").removesuffix(")"))
    known = {entry[4] for entries in index["objects"].values() for entry in entries}
    assert set(gpu_xform.__all__) - {"matrices", "planar", "samples", "dask"} <= known


def test_the_search_finds_a_page(opened: Browser) -> None:
    opened.open(SITE / "search.html", DESKTOP)
    opened.driver.get((SITE / "search.html").as_uri() + "?q=lavapipe")
    opened.wait_for("document.querySelectorAll('#search-results li a').length > 2")
    # The extracts beside the results are fetched, which pages of a server may do, and files may not.
    of_fetching = ("fetch", "net::ERR_FAILED")
    messages = [message for message in opened.console_messages() if not any(part in message for part in of_fetching)]
    assert messages == []
