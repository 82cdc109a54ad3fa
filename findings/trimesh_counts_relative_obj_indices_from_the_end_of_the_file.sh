#!/usr/bin/env bash
# trimesh 5.2.0, NumPy 2.2.6.
#
# Behaviour: a negative index of an OBJ face means, by the format, the points read so far: -1 is the last `v` above the
# face. trimesh counts from the last point of the whole file. A file that interleaves points and faces, as exporters that
# use negative indices do, loads with all its faces on the last points, without a warning.
#
# The guess before: the same triangles as of the file with positive indices, for trimesh reads negative ones.
#
# Seen:
#   positive: area 1.0, corners (0, 0) (1, 0) (0, 1); (5, 0) (6, 0) (5, 1)
#   negative: area 1.0, corners (5, 0) (6, 0) (5, 1); (5, 0) (6, 0) (5, 1)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install trimesh==5.2.0 numpy==2.2.6
"$folder/venv/bin/python" - <<'PYTHON'
import io

import trimesh

TRIANGLES = ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "v 5 0 0\nv 6 0 0\nv 5 1 0\n")
FILES = {
    "positive": TRIANGLES[0] + "f 1 2 3\n" + TRIANGLES[1] + "f 4 5 6\n",
    "negative": TRIANGLES[0] + "f -3 -2 -1\n" + TRIANGLES[1] + "f -3 -2 -1\n",
}
seen = {}
for name, text in FILES.items():
    mesh = trimesh.load(io.BytesIO(text.encode()), file_type="obj", process=False, force="mesh")
    corners = [" ".join(f"({x:g}, {y:g})" for x, y, _ in triangle) for triangle in mesh.triangles]
    seen[name] = corners
    print(f"{name}: area {mesh.area}, corners {'; '.join(corners)}")
assert seen["positive"] == ["(0, 0) (1, 0) (0, 1)", "(5, 0) (6, 0) (5, 1)"], seen
assert seen["negative"] == ["(5, 0) (6, 0) (5, 1)"] * 2, seen
PYTHON
