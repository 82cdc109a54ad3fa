#!/usr/bin/env bash
# lazrs 0.8.2, laspy 2.7.0, Python 3.11.
#
# Behaviour: points of format 9 or 10 that lazrs compresses come back with other waveform fields (offset, place of the
# return, vector) from the third point on behind the first one of another scanner channel. It is the compressor: LASzip
# (the package laszip 0.3.0) reads the same wrong numbers from its files, and lazrs reads right what LASzip has written.
# Formats 4 and 5, which have waveforms and no scanner channels, come back as they were.
#
# The guess before: LAZ is lossless, and the compressor of a library is the inverse of its own decompressor, in all formats.
#
# Seen, for ten points of which the last five are of another channel:
#   format 9, one channel: nothing differs
#   format 9, two channels: wavepacket_offset, return_point_wave_location, x_t, y_t, z_t differ, from point 7 on
#   format 10, one channel: nothing differs
#   format 10, two channels: wavepacket_offset, return_point_wave_location, x_t, y_t, z_t differ, from point 7 on
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install lazrs==0.8.2 laspy==2.7.0 numpy==2.2.6
"$folder/venv/bin/python" - <<'PYTHON'
import io

import laspy
import numpy as np

N_POINTS = 10


def come_back(point_format, channels):
    random = np.random.default_rng(0)
    header = laspy.LasHeader(point_format=point_format, version="1.4")
    las = laspy.LasData(header, laspy.ScaleAwarePointRecord.zeros(N_POINTS, header=header))
    las.scanner_channel = channels
    las.wavepacket_index = np.ones(N_POINTS, np.uint8)
    las.wavepacket_offset = 60 + 64 * np.arange(N_POINTS)
    las.wavepacket_size = np.full(N_POINTS, 64)
    for name in ("return_point_wave_location", "x_t", "y_t", "z_t"):
        las[name] = random.random(N_POINTS)
    file = io.BytesIO()
    las.write(file, do_compress=True, laz_backend=laspy.LazBackend.Lazrs)
    back = laspy.read(io.BytesIO(file.getvalue()), laz_backend=laspy.LazBackend.Lazrs)
    differ = {}
    for name in las.point_format.dimension_names:
        is_other = np.asarray(las[name]) != np.asarray(back[name])
        if is_other.any():
            differ[name] = int(np.argmax(is_other))
    return differ


for point_format in (9, 10):
    one = come_back(point_format, np.zeros(N_POINTS, np.uint8))
    two = come_back(point_format, (np.arange(N_POINTS) >= N_POINTS // 2).astype(np.uint8))
    print(f"format {point_format}, one channel: {one or 'nothing differs'}")
    print(f"format {point_format}, two channels: {', '.join(two)} differ, from point {min(two.values())} on")
    assert not one
    assert set(two) == {"wavepacket_offset", "return_point_wave_location", "x_t", "y_t", "z_t"}
    assert set(two.values()) == {7}
PYTHON
