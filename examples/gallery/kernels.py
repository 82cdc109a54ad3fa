"""What kernels make of a picture.

The same drawing, blurred, its edges by Sobel's kernel, and sharpened: convolution runs on the device too.
"""

import numpy as np
from PIL import Image

import gpu_xform as gx

ball = gx.samples.snub_dodecahedron()
drawn = gx.render(ball, size=(470, 310), fill="face", line_width=2, camera=gx.Camera.window((-3.6, 3.6), (-2.4, 2.4)))
image = np.asarray(drawn.convert("RGB"), np.float32)
slopes = [gx.convolve(image, gx.sobel_kernel(axis), border="edge") for axis in ("x", "y")]
sharpen = [[0, -1, 0], [-1, 5, -1], [0, -1, 0]]
results = [
    image,
    gx.convolve(image, gx.gaussian(5), border="edge"),
    255 - np.hypot(*slopes) / 3,
    gx.convolve(gx.convolve(image, gx.gaussian(2), border="edge"), sharpen, border="edge"),
]
picture = Image.new("RGB", (960, 640), "white")
for i, result in enumerate(results):
    panel = Image.fromarray(np.clip(result, 0, 255).astype(np.uint8))
    picture.paste(panel, (5 + 480 * (i % 2), 5 + 320 * (i // 2)))
picture.save("kernels.png")
