"""Standard input and output: text to print, bytes to read and write, and the file that an error names."""

import contextlib
import errno
import os
import sys
import warnings
from collections.abc import Iterator
from typing import Any, BinaryIO, TextIO

from .._core.printable import escape_controls, escape_line
from .._core.whole_writes import as_whole_writer
from ..errors import MeshError, MeshWarning, SimulationWarning, SizeWarning, TextWarning
from .paths import STDIO

PRINTED = (MeshWarning, SimulationWarning, SizeWarning, TextWarning)


def print_stdout(text: str) -> None:
    """Print to standard output; characters that its encoding lacks, as in an adapter's name, become escapes."""
    with name_file_in_errors(STDIO):
        stream: Any = sys.stdout
        if stream is None or hasattr(stream, "buffer"):
            binary = get_binary_stream("stdout")
            stream.flush()
            binary.write(_encode(text, stream))
            binary.flush()
        else:  # a text alone, in a program of someone else
            stream.write(escape_controls(text))


def print_stderr(text: str) -> None:
    """Print to standard error, if there is one that takes it."""
    with contextlib.suppress(OSError, ValueError):
        if sys.stderr is not None:
            sys.stderr.write(_encode(text, sys.stderr).decode(sys.stderr.encoding or "utf-8"))
            sys.stderr.flush()


def print_notice(text: str) -> None:
    """Print one line to standard error, whatever names in it hold."""
    print_stderr(f"gpu-xform: {escape_line(text)}\n")


def _encode(text: str, stream: TextIO) -> bytes:
    return escape_controls(text).replace("\n", os.linesep).encode(stream.encoding or "utf-8", "backslashreplace")


def flush_stdout() -> None:
    """Write what standard output still buffers."""
    if sys.stdout is not None:
        with name_file_in_errors(STDIO):
            sys.stdout.flush()


def discard_stdout() -> None:
    """Redirect standard output to nowhere if it cannot be flushed: Python would try again at exit."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def get_binary_stream(name: str) -> BinaryIO:
    """Return the bytes of `sys.stdin` or `sys.stdout`; raise `OSError` if the process has none."""
    text = getattr(sys, name)
    if text is None:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF), name)
    return as_whole_writer(text.buffer)


@contextlib.contextmanager
def print_warnings() -> Iterator[None]:
    """Print what the block warns of files and pictures in one line each, and no line twice."""
    with warnings.catch_warnings():
        standard, printed = warnings.showwarning, set[str]()

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if not issubclass(category, PRINTED):
                standard(message, category, filename, lineno, file, line)
                return
            text = " ".join(str(message).split())
            if text not in printed:
                printed.add(text)
                print_notice(f"warning: {text}")

        for category in PRINTED:
            warnings.simplefilter("always", category)
        warnings.showwarning = show
        yield


@contextlib.contextmanager
def raise_warnings() -> Iterator[None]:
    """Make errors of all warnings about model files."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", MeshWarning)
        try:
            yield
        except MeshWarning as warning:
            raise MeshError(str(warning)) from None


@contextlib.contextmanager
def name_file_in_errors(path: str) -> Iterator[None]:
    """Name `path` in failures to write, not the temporary file that stands in for it until it is whole."""
    try:
        yield
    except OSError as error:
        name = "standard output" if path == STDIO else path
        raise OSError(error.errno, error.strerror or str(error), name) from None
