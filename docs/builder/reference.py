"""The reference: docs/api.md, whose names lead to a page with signatures for each of its sections."""

import inspect
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import gpu_xform

from .pages import write

_ROW = re.compile(r"^\| `(\w+)`( *)\|", re.MULTILINE)
_SECTION = re.compile(r"^## (.+)$", re.MULTILINE)
RETURNED = "What functions return"


def write_reference(source: Path) -> None:
    """Write a page for each section of the list of names, and for each module in it; link the list to them."""
    index = source / "reference" / "index.md"
    text = index.read_text("utf-8")
    before, *parts = _SECTION.split(text)
    pages, linked = [], [before]
    for title, body in zip(parts[::2], parts[1::2], strict=True):
        names = [row[0] for row in _ROW.findall(body)] if title != RETURNED else []
        if names:
            pages.append(re.sub(r"\W+", "-", title.lower()))
            write(source / "reference" / f"{pages[-1]}.rst", _describe_names(title, names))
            body = _ROW.sub(lambda row: f"| {{py:obj}}`{row[1]} <gpu_xform.{row[1]}>` |", body)
        linked.append(f"## {title}{body}")
    pages += _write_modules(source)
    contents = "\n".join([*pages, "command", "conventions"])
    write(index, "".join(linked) + f"\n```{{toctree}}\n:hidden:\n\n{contents}\n```\n")


def _write_modules(source: Path) -> list[str]:
    """Write a page for each public module, and return the names of the pages."""
    modules = [name for name in gpu_xform.__all__ if inspect.ismodule(getattr(gpu_xform, name))]
    for name in modules:
        module: ModuleType = getattr(gpu_xform, name)
        functions = [n for n, value in vars(module).items() if n[0] != "_" and _is_defined_in(value, module)]
        entries = "\n".join(f".. autofunction:: {n}" for n in sorted(functions))
        if name == "matrices":  # its functions are public names of the package, and have their entries there
            entries = "Its functions are those of :doc:`Matrices <matrices>`."
        title = f"gpu_xform.{name}"
        head = f"{title}\n{'=' * len(title)}\n\n.. automodule:: gpu_xform.{name}\n   :no-members:\n\n"
        write(source / "reference" / f"module-{name}.rst", head + entries + "\n")
    return [f"module-{name}" for name in modules]


def _is_defined_in(value: Any, module: ModuleType) -> bool:
    return inspect.isfunction(value) and (value.__module__ or "").startswith(module.__name__)


def _describe_names(title: str, names: list[str]) -> str:
    """Return a page with the entries of public names."""
    entries = [f"{title}\n{'=' * len(title)}\n\n.. currentmodule:: gpu_xform\n"]
    for name in names:
        value = getattr(gpu_xform, name)
        if inspect.ismodule(value):
            continue
        if isinstance(value, type) and issubclass(value, Exception):
            entries.append(f".. autoexception:: {name}\n")
        elif isinstance(value, type):
            entries.append(f".. autoclass:: {name}\n   :members:\n")
        else:
            entries.append(f".. autofunction:: {name}\n")
    return "\n".join(entries)


def drop_reading_order(lines: list[str]) -> list[str]:
    """Return the lines of a module's docstring without the paragraph "Reading order: ..."."""
    paragraphs = "\n".join(lines).split("\n\n")
    return "\n\n".join(each for each in paragraphs if not each.startswith("Reading order: ")).split("\n")
