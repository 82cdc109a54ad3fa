"""Links and pictures of Markdown pages, rewritten for where a page stands on the site."""

import posixpath
import re
from collections.abc import Mapping

from .project import REPOSITORY, ROOT

_LINK = re.compile(r"(\]\()([^)\s]+)(\))")
_CENTRED = re.compile(r'<p align="center">(.*?)</p>', re.DOTALL)
_IMAGE = re.compile(r"<img\s+(.*?)>", re.DOTALL)
_ATTRIBUTE = re.compile(r'(\w+)="(.*?)"', re.DOTALL)
_CODE = re.compile(r"(^```.*?^```$|`[^`\n]+`)", re.MULTILINE | re.DOTALL)


def rewrite_page(text: str, path: str, places: Mapping[str, str]) -> str:
    """Return a page for the site, with its links and its centred pictures; code stays as it is.

    path : of the page in the repository
    places : the path on the site of each page of the repository that is there
    """
    parts = _CODE.split(_CENTRED.sub(_show_images, text))
    for k in range(0, len(parts), 2):
        parts[k] = _LINK.sub(lambda found: found[1] + rewrite_link(found[2], path, places) + found[3], parts[k])
    return "".join(parts)


def rewrite_link(target: str, path: str, places: Mapping[str, str]) -> str:
    """Return the target of a link on the site: another page, or the file in the repository; raise if it is nowhere."""
    file, hash_sign, anchor = target.partition("#")
    if not file or re.match(r"[a-z]+:", file):
        return target
    linked = posixpath.normpath(posixpath.join(posixpath.dirname(path), file))
    if linked in places:
        return posixpath.relpath(places[linked], posixpath.dirname(places[path])) + hash_sign + anchor
    if not (ROOT / linked).exists():
        raise FileNotFoundError(f"{path}: a link leads nowhere: {target}")
    if linked.startswith("docs/images/"):
        return posixpath.relpath(linked.removeprefix("docs/"), posixpath.dirname(places[path]))
    kind = "tree" if (ROOT / linked).is_dir() else "blob"
    return f"{REPOSITORY}/{kind}/main/{linked}" + hash_sign + anchor


def _show_images(paragraph: re.Match[str]) -> str:
    """Return the pictures of a centred paragraph as Sphinx copies them."""
    shown = []
    for image in _IMAGE.finditer(paragraph[1]):
        attributes = dict(_ATTRIBUTE.findall(image[1]))
        alt = " ".join(attributes["alt"].split())
        shown.append(f"![{alt}]({attributes['src']}){{width={attributes['width']}px align=center}}")
    return "\n".join(shown)
