"""Hidden lines removed.

The teapot is computed from its 32 Bézier patches, as quads. What lies behind a face is not drawn.
"""

import gpu_xform as gx

picture = gx.render(
    gx.samples.teapot(10), camera={"direction": (-0.5, -0.45, -1)}, hidden="remove", color="#1f3a5f", size=(960, 640)
)
picture.save("teapot.png")
