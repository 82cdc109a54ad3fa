"""The command as its parser has it: a page of the site, and a manual page, `python -m docs.builder.command FILE`."""

import argparse
import re
import sys
from pathlib import Path
from typing import Any, NamedTuple

import gpu_xform
from gpu_xform.cli.commands import SUMMARIES
from gpu_xform.cli.parser import DESCRIPTION, EPILOG, make_parser

from .pages import write


class Option(NamedTuple):
    """An option or a positional argument, as it is typed, and its help."""

    typed: str
    words: str


class Command(NamedTuple):
    """One command; groups are pairs of a title and options, the epilog is text with its own line breaks."""

    name: str
    summary: str
    usage: str
    words: str
    groups: list[tuple[str, list[Option]]]
    epilog: str


def describe_commands() -> list[Command]:
    """Return what the parser knows about each command."""
    parsers: dict[str, Any] = make_parser().get_default("command_parsers")
    commands = []
    for name, parser in parsers.items():
        parser.fill()
        groups = []
        for group in parser._action_groups:  # argparse shows them nowhere else
            options = [_describe(action) for action in group._group_actions if action.help is not argparse.SUPPRESS]
            if options:
                groups.append((group.title or "", options))
        usage = parser.usage.removeprefix("usage: ")
        commands.append(Command(name, SUMMARIES[name], usage, parser.description, groups, parser.epilog))
    return commands


def _describe(action: argparse.Action) -> Option:
    words = (action.help or "") % {**vars(action), "default": action.default}
    if not action.option_strings:
        return Option(str(action.metavar or action.dest), words)
    value = f" {action.metavar}" if action.metavar and action.nargs != 0 else ""
    return Option(", ".join(action.option_strings) + value, words)


def write_command_page(source: Path) -> None:
    """Write the page of all commands and options."""
    lines = ["# The command `gpu-xform`", "", DESCRIPTION, ""]
    for command in describe_commands():
        lines += [f"## {command.name}", "", f"`{' '.join(command.usage.split())}`", "", _join(command.words), ""]
        for title, options in command.groups:
            lines += [f"### {title[:1].upper() + title[1:]}", ""]
            lines += [f"`{option.typed}`\n: {escape(option.words)}\n" for option in options]
        lines += ["```text", command.epilog.rstrip(), "```", ""]
    write(source / "reference" / "command.md", "\n".join(lines))


def _join(text: str) -> str:
    return escape(" ".join(text.split()))


def escape(text: str) -> str:
    """Return plain text as Markdown."""
    return re.sub(r"([*_<>|$\[\]{}])", r"\\\1", text)


def format_man_page() -> str:
    """Return the manual page in the macros of man(7)."""
    lines = [
        f'.TH GPU-XFORM 1 "" "gpu_xform {gpu_xform.__version__}" "User Commands"',
        ".SH NAME",
        f"gpu-xform \\- {_roff(DESCRIPTION[0].lower() + DESCRIPTION[1:].removesuffix('.'))}",
        ".SH SYNOPSIS",
        ".B gpu-xform",
        "COMMAND ...",
        ".SH COMMANDS",
    ]
    commands = describe_commands()
    for command in commands:
        lines += [".TP", f".B {_roff(command.name)}", _roff(command.summary)]
    for command in commands:
        lines += [f'.SH "GPU-XFORM {command.name.upper()}"', f".B {_roff(' '.join(command.usage.split()))}", ".PP"]
        lines += [_roff(" ".join(paragraph.split())) + "\n.PP" for paragraph in command.words.split("\n\n")]
        for title, options in command.groups:
            lines.append(f'.SS "{_roff(title[:1].upper() + title[1:])}"')
            for option in options:
                lines += [".TP", f".B {_roff(option.typed)}", _roff(option.words)]
        lines += [".SS Notes and examples", ".nf", _roff(command.epilog.rstrip()), ".fi"]
    lines += [".SH NOTES", ".nf", _roff(EPILOG.rstrip()), ".fi"]
    return "\n".join(lines) + "\n"


def _roff(text: str) -> str:
    """Return text in which nothing is a request or an escape of roff."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", escaped, flags=re.MULTILINE).replace('"', "\\(dq")


if __name__ == "__main__":
    write(Path(sys.argv[1]), format_man_page())
