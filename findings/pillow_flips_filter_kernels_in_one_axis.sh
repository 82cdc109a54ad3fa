#!/usr/bin/env bash
# Pillow 13.0.0, NumPy 2.2.6.
#
# Behaviour: ImageFilter.Kernel neither correlates nor convolves. It turns the kernel upside down, and then correlates: an
# image that is 1 in one pixel comes out as the kernel mirrored from left to right alone. scipy.ndimage and OpenCV mirror
# in both axes or in none. A Sobel kernel of the horizontal gradient works, one of the vertical has the wrong sign.
#
# The guess before: one of the two, so that the image of one pixel shows the kernel as it is, or turned by half a turn.
#
# Seen:
#   [[3, 2, 1], [6, 5, 4], [9, 8, 7]]
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install pillow==13.0.0 numpy==2.2.6
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
from PIL import Image, ImageFilter

kernel = np.arange(1, 10).reshape(3, 3)
pixels = np.zeros((5, 5), np.uint8)
pixels[2, 2] = 1
filtered = Image.fromarray(pixels).filter(ImageFilter.Kernel((3, 3), kernel.ravel().tolist(), scale=1))
seen = np.asarray(filtered)[1:4, 1:4]
print(seen.tolist())
assert not np.array_equal(seen, kernel)  # convolution
assert not np.array_equal(seen, kernel[::-1, ::-1])  # correlation
assert np.array_equal(seen, kernel[:, ::-1])
PYTHON
