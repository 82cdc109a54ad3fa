"""`gpu-xform completion`: a script that completes commands, options and files in a shell."""

import argparse
from typing import Any

from ...errors import MissingExtraError
from .. import options as groups
from ..completions import find_completions
from ..streams import print_stdout

USAGE = "bash|zsh|tcsh"
DESCRIPTION = """\
Print a script that completes the commands, options and values of gpu-xform in
a shell. Needs: pip install 'gpu_xform[completion]'."""
EPILOG = """\
examples, the folder of zsh in $fpath, and the file of tcsh read by ~/.tcshrc:
  gpu-xform completion bash \\
      > ~/.local/share/bash-completion/completions/gpu-xform
  gpu-xform completion zsh > ~/.zsh/functions/_gpu-xform
  gpu-xform completion tcsh > ~/.gpu-xform.csh
"""
SHELLS = ("bash", "zsh", "tcsh")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `completion`."""
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help="the shell: bash, zsh or tcsh")
    groups.add_general_options(parser, adapter=False)


def run(options: argparse.Namespace) -> int:
    """Print the script."""
    try:
        import shtab
    except ImportError as error:
        raise MissingExtraError(f"completion needs shtab: pip install 'gpu_xform[completion]' ({error})") from None
    for parser in options.command_parsers.values():
        parser.fill()
    functions = {}
    for action, completion in find_completions(options.command_parsers).items():
        functions[completion.function] = completion.format_function(options.shell)
        named: Any = dict.fromkeys(SHELLS, completion.function) | {"tcsh": completion.format_tcsh()}
        action.complete = named  # type: ignore[attr-defined]
    preamble = "" if options.shell == "tcsh" else "\n".join(functions.values())
    print_stdout(shtab.complete(options.whole_parser, shell=options.shell, preamble=preamble))
    return 0
