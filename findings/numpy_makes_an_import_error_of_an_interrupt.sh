#!/usr/bin/env bash
# NumPy 2.4.6; CPython 3.11.7 (and 3.14.8, with NumPy 2.5.5).
#
# Behaviour: Ctrl+C while the compiled part of NumPy is loaded is raised at the next line of Python, which is in `datetime`,
# that this part imports. PyCapsule_Import puts an ImportError in place of whatever is raised in there, and NumPy one with
# advice about a bad installation around it. The KeyboardInterrupt is neither the cause nor the context of any of them, so
# that a program exits with 1 and a long message, or takes NumPy for a package that is not there.
#
# The guess before: KeyboardInterrupt comes out of the import, as where Python code imports `datetime`.
#
# Seen:
#   import datetime: KeyboardInterrupt
#   import numpy: ImportError, ImportError
#   its last line: Original error was: PyCapsule_Import could not import module "datetime"
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install numpy==2.4.6
cat > "$folder/program.py" <<'PYTHON'
import signal
import sys


class Finder:
    """Raises SIGINT where `datetime` is imported, as a user may who waits for the library to be loaded."""

    def find_spec(self, name, path=None, target=None):
        if name == "datetime":
            signal.raise_signal(signal.SIGINT)


def chain(error):
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


sys.meta_path.insert(0, Finder())
try:
    __import__(sys.argv[1])
except BaseException as error:
    print(f"import {sys.argv[1]}: " + ", ".join(type(each).__name__ for each in chain(error)))
    if str(error):
        print("its last line:", str(error).strip().splitlines()[-1])
PYTHON
seen=$("$folder/venv/bin/python" "$folder/program.py" datetime; "$folder/venv/bin/python" "$folder/program.py" numpy)
echo "$seen"
test "$seen" = 'import datetime: KeyboardInterrupt
import numpy: ImportError, ImportError
its last line: Original error was: PyCapsule_Import could not import module "datetime"'
