"""Command-line parser: the top-level options, and those of the chosen command."""

import argparse
import functools
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from .. import __version__
from .._core.interrupts import INTERRUPTED, TERMINATED, defer_interrupts
from ..errors import ArgumentError
from .argv import OptionParser, attach_values
from .commands import SUMMARIES
from .exit_codes import DEVICE_FAILED, MISMATCH, NO_ADAPTER, PIPE_CLOSED, WRONG_INPUT
from .paths import require_path
from .streams import print_stderr, print_stdout

HELP_COLUMN = 31

DESCRIPTION = "Bulk homogeneous transforms and wireframe pictures on any GPU, or on none."
EPILOG = f"""\
examples:
  gpu-xform render house.obj -o house.png --rotate-y 30 --color face
  gpu-xform render *.obj -o "thumbs/{{model}}.png"
  gpu-xform animate house.obj -o house.gif --color face
  gpu-xform simulate cloth -o scarf.gif --sphere 0,-0.3,0,0.25
  gpu-xform view house.obj
  gpu-xform transform scan.ply moved.ply --scale 0.001 --translate -0.5,2,0
  gpu-xform convolve photo.png soft.png --gaussian 2
  gpu-xform info scan.ply
  gpu-xform explain --scale 0.3 --rotate-z 90 --translate -0.5,2,0 --point 1,1,0
  gpu-xform doctor
  gpu-xform bench

exit codes:
  0    done
  {DEVICE_FAILED}    the device failed, or its results are wrong
  {WRONG_INPUT}    wrong usage or input
  {NO_ADAPTER}    no graphics adapter: gpu-xform doctor says what to install
  {MISMATCH}    a picture does not match its reference
  {INTERRUPTED}  interrupted, by Ctrl+C
  {PIPE_CLOSED}  whoever reads standard output has closed it
  {TERMINATED}  asked to end, by SIGTERM

gpu-xform COMMAND --help describes the options of a command.
"""


class Parser(OptionParser):
    """An argument parser that reports errors in one line."""

    def error(self, message: str) -> NoReturn:
        """Print what is wrong with the command line, and exit."""
        self.exit(WRONG_INPUT, f"gpu-xform: error: {' '.join(message.split())}\n")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help, or an error: argparse itself passes over what cannot be written, and exits with 0."""
        if file is sys.stderr:
            print_stderr(message)
        else:
            print_stdout(message)


class CommandParser(Parser):
    """The parser of one command, which gets its texts and options from the command's module when it is used."""

    def __init__(self, command: str, **settings: Any) -> None:
        super().__init__(**settings)
        self._command = command
        self._is_filled = False

    def fill(self) -> None:
        """Import the command, and add its texts and options; `run` and `parser` of the result are the command's own."""
        if self._is_filled:
            return
        self._is_filled = True
        with defer_interrupts():  # the compiled part of NumPy makes an ImportError of one that is raised in its import
            command = import_module(f".commands.{self._command}", __package__)
        self.usage = f"gpu-xform {self._command} {command.USAGE}"
        self.description = command.DESCRIPTION
        self.epilog = command.EPILOG
        command.add_options(self)
        self.set_defaults(run=command.run, parser=self)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Fill the parser, and parse."""
        self.fill()
        return super().parse_known_args(args, namespace)


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Return the options of a command line; for --help, --version and errors, print and raise SystemExit."""
    parser = make_parser()
    options, rest = parser.parse_known_args(attach_values(argv))
    if "models" in options and not any(re.match("-.", word) for word in rest):
        options.models += rest  # argparse takes positional arguments only up to the first option between them
        _require_models(parser, options.models, takes_folders=options.command == "render")
    elif rest:
        chosen = parser if options.command is None else options.parser
        parser.error(f"unrecognized arguments: {' '.join(rest)}{chosen.did_you_mean(rest)}")
    if options.command is None:
        *others, last = SUMMARIES
        parser.error(f"a command is needed: {', '.join(others)} or {last}; see gpu-xform --help")
    return options


def _require_models(parser: Parser, models: Sequence[str], *, takes_folders: bool) -> None:
    try:
        for path in models:
            if not (takes_folders and path and Path(path).is_dir()):
                require_path(path)
    except ArgumentError as error:
        parser.error(f"argument MODEL: {error}")


def make_parser() -> Parser:
    """Return the parser of the whole command line."""
    parser = Parser(
        prog="gpu-xform",
        usage="gpu-xform COMMAND ...",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", parser_class=CommandParser)
    for name, summary in SUMMARIES.items():
        commands.add_parser(
            name,
            command=name,
            help=summary,
            formatter_class=functools.partial(argparse.RawDescriptionHelpFormatter, max_help_position=HELP_COLUMN),
        )
    group = parser.add_argument_group("other options")
    group.add_argument("-h", "--help", action="help", help="print this help")
    group.add_argument(
        "-V", "--version", action="version", version=f"gpu-xform {__version__}", help="print the version"
    )
    parser.set_defaults(whole_parser=parser, command_parsers=commands.choices)
    return parser
