#!/usr/bin/env bash
# rendercanvas 2.7.2 with anywidget 0.11.0, CPython 3.11, Linux.
#
# Behaviour: `close()` of the widget of rendercanvas.anywidget calls itself through the message "close" that it sends to
# itself, and ends in a RecursionError, with the widget gone, but not counted as closed.
#
# The guess before: it closes the widget once, as `close()` of the other back ends closes a window.
#
# Seen:
#   RecursionError, closed: False
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install rendercanvas==2.7.2 anywidget==0.11.0
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

from rendercanvas.anywidget import RenderCanvas

assert importlib.metadata.version("rendercanvas") == "2.7.2"
canvas = RenderCanvas(size=(64, 48))
try:
    canvas.close()
    outcome = "closed"
except RecursionError:
    outcome = "RecursionError"
print(f"{outcome}, closed: {canvas.get_closed()}")
assert (outcome, canvas.get_closed()) == ("RecursionError", False)
PYTHON
