#!/usr/bin/env bash
# CPython 3.11 (seen with 3.11.2 and 3.11.7), Linux; no package.
#
# Behaviour: a KeyboardInterrupt that comes out of `exec` of a text, and that is caught, leaves a mark. At the end of a
# module that `python -m` runs, whatever `sys.exit` was given, Python ends itself by SIGINT; not so a file. `exec` of code that was compiled
# before leaves none, and any later `exec` of a text that ends well takes the mark back. Dataclasses and named tuples are
# made by `exec` of texts, so an ordinary Ctrl+C during imports can leave it.
#
# The guess before: an exception that is caught is over, and the exit code is the one that was given.
#
# Seen, for sys.exit(7) after the exception was caught:
#   text: -2; compiled: 7; text, and another text later: 7; text, as a file: 7
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/program.py" <<'PYTHON'
import sys

code = "raise KeyboardInterrupt"
if sys.argv[1] == "compiled":
    code = compile(code, "text", "exec")
try:
    exec(code)
except KeyboardInterrupt:
    pass
if sys.argv[1] == "later":
    exec("")
sys.exit(7)
PYTHON
cd "$folder"
python3 - <<'PYTHON'
import subprocess
import sys

assert sys.version_info[:2] == (3, 11), sys.version
module, file = ["-m", "program"], ["program.py"]
runs = [*module, "text"], [*module, "compiled"], [*module, "later"], [*file, "text"]
codes = [subprocess.run([sys.executable, *typed]).returncode for typed in runs]
print("text: {}; compiled: {}; text, and another text later: {}; text, as a file: {}".format(*codes))
assert codes == [-2, 7, 7, 7]
PYTHON
