"""The command `gpu-xform`: parse the options, call the library, report each failure in one line and an exit code.

Reading order: exit_codes, argv, paths, streams, stage_times, reading_options, files, matrix_table, image_files,
path_templates, argument_types, options, completions, model_paths, layer_option, camera_options, arguments_from_options,
read_layers, option_errors, scan_rows, outputs, outcome, references, web_pages, contact_sheet, reports, make_pictures,
commands, parser.
"""

import sys
from collections.abc import Sequence

from .._core.interrupts import describe_interrupt
from .exit_codes import FAILURES, PIPE_CLOSED, exit_code_for, format_error
from .parser import parse
from .reading_options import use_typed_limits
from .stage_times import report_stages
from .streams import discard_stdout, flush_stdout, print_stderr, print_warnings

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`, by default that of the process, and return the exit code."""
    try:
        with print_warnings():
            code = _run(sys.argv[1:] if argv is None else argv)
        flush_stdout()
    except KeyboardInterrupt as interrupt:
        code, line = describe_interrupt(interrupt)
        discard_stdout()
        print_stderr(line)
    except BrokenPipeError:
        discard_stdout()
        return PIPE_CLOSED
    except FAILURES as error:
        if isinstance(error, OSError):
            discard_stdout()
        print_stderr(format_error(error))
        return exit_code_for(error)
    return code


def _run(argv: Sequence[str]) -> int:
    try:
        options = parse(argv)
    except SystemExit as stop:  # argparse has printed help, the version, or what is wrong
        return int(stop.code or 0)
    with report_stages(getattr(options, "verbose", False)), use_typed_limits(options):
        return int(options.run(options))
