"""The Lorenz attractor.

A path of 30,000 steps in the colours of time; nearer parts of it lie over farther ones.
"""

import numpy as np

import gpu_xform as gx

n, dt = 30_000, 0.0025
path = np.empty((n, 3))
path[0] = 0.1, 0.0, 20.0
for i in range(1, n):
    x, y, z = path[i - 1]
    path[i] = path[i - 1] + dt * np.array([10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z])
curve = gx.Mesh(path, np.column_stack([np.arange(n - 1), np.arange(1, n)]))
picture = gx.render(
    curve,
    scalars=np.arange(n),
    cmap="turbo",
    line_width=1.2,
    depth_cue=0.6,
    camera={"direction": (-0.55, 1, -0.15), "up": (0, 0, 1), "margin": 0.02},
    background="#101218",
    size=(960, 640),
)
picture.save("attractor.png")
