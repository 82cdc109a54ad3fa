#!/usr/bin/env bash
# lazrs 0.8.2, laspy 2.7.0, Python 3.11.
#
# Behaviour: for a LAZ file in chunks of 50,000 points, `read_chunk_table` and `read_chunk_table_only` read the same table
# and disagree on its counts of points: the first says 50,000 for every chunk, the last one included, whatever is in it;
# the second says 0 for every chunk. The counts of bytes are the same, and right.
#
# The guess before: both return the points that each chunk holds, so that the counts add up to the points of the file.
#
# Seen, for 120,000 points:
#   read_chunk_table: counts 50000, 50000, 50000, in all 150000
#   read_chunk_table_only: counts 0, 0, 0, in all 0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install lazrs==0.8.2 laspy==2.7.0 numpy==2.2.6
"$folder/venv/bin/python" - <<'PYTHON'
import io
import struct

import laspy
import lazrs
import numpy as np

N_POINTS = 120_000
las = laspy.LasData(laspy.LasHeader(point_format=3, version="1.2"))
las.x, las.y, las.z = np.arange(N_POINTS) * np.array([[0.01], [0.02], [0.0]])
file = io.BytesIO()
las.write(file, do_compress=True, laz_backend=laspy.LazBackend.Lazrs)
content = file.getvalue()

with laspy.open(io.BytesIO(content)) as reader:
    start = reader.header.offset_to_point_data
    vlr = lazrs.LazVlr(reader.header.vlrs.get("LasZipVlr")[0].record_data)
    assert reader.header.point_count == N_POINTS == len(reader.read())
(table_start,) = struct.unpack_from("<q", content, start)  # LAZ begins its points with where its table is

tables = []
for read, offset in ((lazrs.read_chunk_table, start), (lazrs.read_chunk_table_only, table_start)):
    source = io.BytesIO(content)
    source.seek(offset)
    counts, sizes = zip(*read(source, vlr))
    print(f"{read.__name__}: counts {', '.join(map(str, counts))}, in all {sum(counts)}")
    assert sum(sizes) == table_start - start - 8, "the bytes do not add up"
    tables.append(counts)
assert tables == [(50_000, 50_000, 50_000), (0, 0, 0)]
PYTHON
