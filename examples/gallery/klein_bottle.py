"""A Klein bottle.

Its inside is its outside; faces are translucent, so the neck shows where it enters.
"""

import gpu_xform as gx

bottle = gx.samples.klein_bottle(96, 40)
picture = gx.render(
    bottle,
    fill="#7fb3d5",
    shading="flat",
    alpha=0.45,
    color="#123a5a",
    line_width=0.7,
    hidden="show",
    camera={"direction": (0.2, -0.15, -1)},
    size=(960, 640),
)
picture.save("klein_bottle.png")
