"""`gpu-xform completion`: a script that completes commands, options and files in a shell."""

import argparse

from ...errors import MissingExtraError
from .. import options as groups
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
FILES = {"DIR", "FILE", "IN", "MODEL", "'MODEL ...'", "NPY", "OUT", "PNG"}  # what options call a path


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
        for action in parser._actions:  # argparse shows them nowhere else
            if action.metavar in FILES:
                action.complete = shtab.FILE
    print_stdout(shtab.complete(options.whole_parser, shell=options.shell))
    return 0
