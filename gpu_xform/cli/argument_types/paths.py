"""Paths: of files, of reports and sheets, and with placeholders."""

from ..._core.targets import is_zarr_path
from ..path_templates import Template
from ..paths import STDIO, file_type, require_path, require_type
from .texts import argument_type, quote

PICTURE_TYPES = ("png", "svg", "pdf")
PAGE_TYPES = ("html", "htm")  # of web pages, which draw the models themselves
REPORT_TYPES = ("html", "json", "xml")


@argument_type
def parse_file_path(text: str) -> str:
    """Parse the path of a file, not of a folder."""
    require_path(text)
    return text


@argument_type
def parse_points_path(text: str) -> str:
    """Parse the path of a file, or of a Zarr array, which is a folder and may end so."""
    return parse_file_path(stripped if is_zarr_path(stripped := text.rstrip("/\\")) else text)


@argument_type
def parse_template(text: str) -> Template:
    """Parse a path, with or without placeholders such as {model}."""
    return Template(text)


@argument_type
def parse_report_path(text: str) -> str:
    """Parse the path of a report, whose type there is."""
    return _parse_typed_path(text, REPORT_TYPES)


@argument_type
def parse_sheet_path(text: str) -> str:
    """Parse the path of a contact sheet."""
    return _parse_typed_path(text, PICTURE_TYPES)


@argument_type
def parse_array_file(text: str) -> Template:
    """Parse the name of an .npy file."""
    if not is_npy_file(text):
        raise ValueError(f"expected an .npy file, got {quote(text)}")
    return Template(text)


def _parse_typed_path(text: str, known: tuple[str, ...]) -> str:
    path = parse_file_path(text)
    if path == STDIO:
        raise ValueError(f"expected a file of type {', '.join(known)}, not standard output")
    require_type(path, known)
    return path


def is_npy_file(text: str) -> bool:
    """Return whether a path is that of an .npy file."""
    return text != STDIO and file_type(text) == "npy"
