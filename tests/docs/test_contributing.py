"""CONTRIBUTING.md names targets and files that exist, and a commit is checked by what `make check` runs."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")


def recipe(target: str) -> list[str]:
    """Return the commands of a target."""
    found = re.search(rf"^{target}:.*\n((?:\t.*\n)+)", MAKEFILE, re.MULTILINE)
    assert found is not None
    return [line.strip().lstrip("@").replace("$(BIN)", ".venv/bin") for line in found[1].splitlines()]


def test_pre_commit_runs_what_make_check_runs() -> None:
    hooks = (ROOT / ".pre-commit-config.yaml").read_text("utf-8")
    assert re.findall(r"^ +entry: (.+)$", hooks, re.MULTILINE) == recipe("check")
    assert re.findall(r"repo: (\S+)", hooks) == ["local"]


def test_the_page_names_targets_that_exist() -> None:
    named = set(re.findall(r"(?:^|`)make ([a-z-]+)", PAGE, re.MULTILINE))
    targets = set(re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE))
    assert {"test", "test-quick", "check", "bench", "driver"} <= named <= targets


def test_the_page_names_files_that_exist() -> None:
    for path in re.findall(r"`([\w.-]+/[\w./-]*|\w+\.\w+)`", PAGE):
        assert path in ("test-failures/", "build/site/html") or (ROOT / path).exists(), path


def test_the_quick_tests_install_neither_a_browser_nor_a_screen() -> None:
    for target, needs in {"test": True, "test-quick": False}.items():
        found = re.search(rf"^{target}: (.*?) ##", MAKEFILE, re.MULTILINE)
        assert found is not None
        assert bool({"browser", "screen"} & set(found[1].split())) == needs
    assert recipe("test-quick") == [f'{recipe("test")[0]} -m "not (browser or screen or slow)"']
