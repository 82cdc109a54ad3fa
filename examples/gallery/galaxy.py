"""A galaxy of points.

250,000 stars along four spiral arms: an array of points is a model, and each point may have a colour.
"""

import numpy as np

import gpu_xform as gx

rng = np.random.default_rng(3)
n = 250_000
radius = rng.gamma(2.2, 0.16, n)
arm = rng.integers(4, size=n) * np.pi / 2 + rng.normal(0, 0.24 + 0.10 / (radius + 0.2), n)
angle = arm + 3.2 * np.log(radius + 0.12)
points = np.column_stack([radius * np.cos(angle), rng.normal(0, 0.045 * np.exp(-radius), n), radius * np.sin(angle)])
warm = np.exp(-2.3 * radius)[:, None]
colors = warm * [1.0, 0.86, 0.6] + (1 - warm) * [0.55, 0.7, 1.0]
picture = gx.render(
    points[radius < 1.15],
    vertex_colors=colors[radius < 1.15],
    alpha=0.3,
    point_size=1.6,
    camera={"direction": (0.2, -0.75, -1), "margin": 0.0},
    background="#05060d",
    size=(960, 600),
)
picture.save("galaxy.png")
