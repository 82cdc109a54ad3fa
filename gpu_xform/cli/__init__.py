"""The command `gpu-xform`: it parses, calls the library, and turns every failure into one line and an exit code.

Reading order: argv, exit_codes, files, argument_types, camera_options, path_templates, references, outputs, options,
layer_option, read_layers, commands, parser.
"""

import os
import sys
from collections.abc import Sequence

from . import exit_codes as failures
from . import files
from .parser import parse

__all__ = ["main"]

INTERRUPTED = 130
PIPE_CLOSED = 141  # what a shell reports of a program that SIGPIPE ended


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`, by default the process's own; return the exit code."""
    try:
        code = _run(sys.argv[1:] if argv is None else argv)
        files.flush()
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        _abandon_output()
        return PIPE_CLOSED
    except failures.FAILURES as error:
        if isinstance(error, OSError):
            _abandon_output()
        sys.stderr.write(failures.line(error))
        return failures.exit_code(error)
    return code


def _run(argv: Sequence[str]) -> int:
    try:
        options = parse(argv)
    except SystemExit as stop:  # argparse has printed help, the version, or what is wrong
        return int(stop.code or 0)
    code: int = options.run(options)
    return code


def _abandon_output() -> None:
    """Send what standard output still holds, where it cannot be written, to nowhere: Python tries again at exit."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
