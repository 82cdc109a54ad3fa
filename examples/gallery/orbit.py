"""A model that turns.

An animated WebP; GIF, PNG, MP4 and a page with a player are other endings of the same call.
"""

import gpu_xform as gx

ball = gx.samples.snub_dodecahedron()
gx.turntable(ball, 48, "orbit.webp", fps=16, size=(480, 320), hidden="remove", line_width=2, color="#1f3a5f")
