"""XML of files that declare no document type, through lxml: no entity is expanded, and no other file opened."""

import re
from typing import Any

from .._core.interrupts import defer_interrupts
from ..errors import MeshError, MissingExtraError

# XML has a document type before its first element alone. One that no such pattern sees, as of a text in UTF-7, is seen
# when it is parsed, which costs what libxml2 lets entities in attributes expand to.
_DOCUMENT_TYPE = re.compile(rb"(?:[^<]++|<\?.*?\?>|<!--.*?-->)*+<!DOCTYPE", re.DOTALL)


def parse_xml(data: bytes, format_name: str) -> Any:
    """Return the root of a file without its comments.

    Raises MeshError for what is no XML, or declares a document type; MissingExtraError without the extra `robots`.
    """
    try:
        with defer_interrupts():
            from lxml import etree
    except ImportError:
        raise MissingExtraError(f"{format_name} needs lxml: pip install 'gpu_xform[robots]'") from None
    if _DOCUMENT_TYPE.match(data.replace(b"\0", b"")):  # of UTF-16, too
        raise MeshError("it declares a document type")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise MeshError(f"it is not XML: {error}") from None
    if root.getroottree().docinfo.internalDTD is not None:
        raise MeshError("it declares a document type")
    return root
