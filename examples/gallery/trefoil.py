"""A knot.

A tube along a trefoil knot, in the colours of the place along it, shaded.
"""

import numpy as np

import gpu_xform as gx

knot = gx.samples.trefoil_tube(240, 24)
around = np.arctan2(knot.positions[:, 1], knot.positions[:, 0])
hue = 0.5 + 0.5 * np.cos(around[:, None] + np.array([0, 2, 4]))
faces = np.array([hue[list(face)].mean(axis=0) for face in knot.faces])
picture = gx.render(
    knot,
    fill=0.25 + 0.75 * faces,
    shading="flat",
    edges="silhouette",
    line_width=2.5,
    size=(960, 640),
    camera={"direction": (-0.2, -0.35, -1)},
)
picture.save("trefoil.png")
