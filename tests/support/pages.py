"""Pages of the documentation, whose blocks of Python and of commands are run in order, in one folder."""

import os
import re
import shlex
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from gpu_xform.cli import main

_BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_EXIT = re.compile(r"  # exits with (\d+)$")


class Ran(NamedTuple):
    """What a page did: the names of its Python blocks, and the lines of its commands."""

    names: dict[str, Any]
    commands: list[str]


def run_page(path: Path, folder: Path, patch: pytest.MonkeyPatch) -> Ran:
    """Run the blocks of a page in `folder`: Python in one namespace, `gpu-xform` in this process.

    A command must end with 0, or with the code that a remark behind it says. Lines of `pip` and
    `make` are left out.
    """
    patch.chdir(folder)
    ran = Ran({}, [])
    page = path.read_text("utf-8")
    for block in _BLOCK.finditer(page):
        first = page.count("\n", 0, block.start(2))
        if block[1] == "python":
            exec(compile("\n" * first + block[2], str(path), "exec"), ran.names)  # noqa: S102 - our own page
            continue
        for line in block[2].replace("\\\n", " ").splitlines():
            if line.startswith("gpu-xform "):
                ran.commands.append(line)
                expected = int(found[1]) if (found := _EXIT.search(line)) else 0
                assert main(shlex.split(line, comments=True)[1:]) == expected, line
            else:
                assert line.startswith(("make ", "pip ")), line
    assert Path.cwd() == Path(os.path.realpath(folder))
    return ran
