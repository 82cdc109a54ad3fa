"""The command `gpu-xform`: it parses, calls the library, and turns every failure into one line and an exit code."""

import os
import sys
from collections.abc import Sequence

from ..errors import DeviceError, GpuXformError, NoAdapterError, ShaderError
from . import files
from .commands import DEVICE_FAILED, NO_ADAPTER, WRONG_INPUT
from .parser import attach_values, make_parser

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
    except OSError as error:
        _abandon_output()
        reason = error.strerror or str(error)
        return _fail(f"{error.filename}: {reason}" if error.filename else reason, WRONG_INPUT)
    except MemoryError as error:
        return _fail(str(error) or "not enough memory", WRONG_INPUT)
    except NoAdapterError as error:
        return _fail(str(error), NO_ADAPTER)
    except (DeviceError, ShaderError) as error:
        return _fail(str(error), DEVICE_FAILED)
    except GpuXformError as error:
        return _fail(str(error), WRONG_INPUT)
    return code


def _run(argv: Sequence[str]) -> int:
    parser = make_parser()
    try:
        options = parser.parse_args(attach_values(argv))
        if options.command is None:
            parser.error("a command is needed: render, transform, explain, doctor or bench; see gpu-xform --help")
    except SystemExit as stop:  # argparse has printed help, the version, or what is wrong
        return int(stop.code or 0)
    code: int = options.run(options)
    return code


def _fail(message: str, code: int) -> int:
    sys.stderr.write(f"gpu-xform: error: {' '.join(message.split())}\n")
    return code


def _abandon_output() -> None:
    """Send what standard output still holds, where it cannot be written, to nowhere: Python tries again at exit."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
