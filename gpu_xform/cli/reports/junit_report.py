"""JUnit report, for CI services: a test case per picture, and a skipped one per reference that is of no model."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from ..._core.printable import escape_controls
from ..exit_codes import MISMATCH
from ..outcome import Outcome
from .run_facts import RunFacts

SUITE = "gpu-xform render"


def format_junit(outcomes: Sequence[Outcome], facts: RunFacts) -> bytes:
    """Return the report as XML: a picture that does not match is a failure, one that could not be made an error.

    The difference of a failure is named as GitLab expects attachments of test cases.
    """
    n_failures = sum(outcome.exit_code == MISMATCH for outcome in outcomes)
    counts = {
        "tests": str(len(outcomes) + len(facts.unused)),
        "failures": str(n_failures),
        "errors": str(sum(not outcome.is_good for outcome in outcomes) - n_failures),
        "skipped": str(len(facts.unused)),
        "time": f"{facts.time_s:.3f}",
    }
    root = ElementTree.Element("testsuites", {"name": SUITE, **counts})
    suite = ElementTree.SubElement(root, "testsuite", {"name": SUITE, **counts, "timestamp": facts.began})
    properties = ElementTree.SubElement(suite, "properties")
    for name, value in (("version", facts.version), ("adapter", facts.adapter)):
        ElementTree.SubElement(properties, "property", {"name": name, "value": _clean(value)})
    for outcome in outcomes:
        _add_case(suite, outcome)
    for path in facts.unused:
        case = _add_test_case(suite, path, 0.0)
        ElementTree.SubElement(case, "skipped", {"message": "no model has this reference"})
    ElementTree.indent(root, " ")
    document: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return document + b"\n"


def _add_case(suite: ElementTree.Element, outcome: Outcome) -> None:
    case = _add_test_case(suite, outcome.picture.name, outcome.time_s)
    if not outcome.is_good:
        kind = "failure" if outcome.exit_code == MISMATCH else "error"
        problem = ElementTree.SubElement(case, kind, {"message": _clean(outcome.message), "type": outcome.status})
        paths = {
            "picture": None if outcome.status == "failed" else outcome.picture.output,
            "reference": outcome.picture.reference,
            "difference": outcome.picture.difference if outcome.numbers is not None else None,
        }
        lines = [outcome.message, *(f"{name}: {path}" for name, path in paths.items() if path is not None)]
        problem.text = _clean("\n".join(lines))
        if paths["difference"] is not None:
            ElementTree.SubElement(case, "system-out").text = _clean(f"[[ATTACHMENT|{paths['difference']}]]")


def _add_test_case(suite: ElementTree.Element, path: str, time_s: float) -> ElementTree.Element:
    names = {"classname": str(Path(path).parent), "name": Path(path).name}
    cleaned = {name: _clean(value) for name, value in names.items()}
    return ElementTree.SubElement(suite, "testcase", {**cleaned, "time": f"{time_s:.3f}"})


def _clean(text: str) -> str:
    """Return a text without what XML cannot hold: control characters, and bytes of names that are no UTF-8."""
    return escape_controls(text).encode("utf-8", "backslashreplace").decode()
