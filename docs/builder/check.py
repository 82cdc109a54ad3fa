"""What Sphinx does not check: links, pictures and scripts of the finished pages lead to files, anchors to places."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class _Page(HTMLParser):
    """The targets and the anchors of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.targets: set[str] = set()
        self.anchors: set[str] = {"", "top"}
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("href", "src", "poster") and value and not (tag == "link" and value.startswith("http")):
                self.targets.add(value)
            elif name in ("id", "name") and value:
                self.anchors.add(value)


def find_broken_links(site: Path) -> list[str]:
    """Return a line for each link of the pages in `site` that leads nowhere; addresses elsewhere are not opened."""
    pages = {
        path.resolve(): _Page(path.read_text("utf-8"))
        for path in sorted(site.rglob("*.html"))
        if "_static" not in path.parts
    }
    broken = []
    for path, page in pages.items():
        for target in sorted(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            linked = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            linked = linked / "index.html" if linked.is_dir() else linked
            if not linked.is_file():
                broken.append(f"{path.relative_to(site.resolve())}: {target} leads to no file")
            elif linked in pages and unquote(parts.fragment) not in pages[linked].anchors:
                broken.append(f"{path.relative_to(site.resolve())}: {target} leads to no place of the page")
    return broken
