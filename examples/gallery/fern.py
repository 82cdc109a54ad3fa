"""A fern of four matrices.

Barnsley's fern: 300,000 points, each the image of another under one of four affine maps of the plane.
"""

import numpy as np

import gpu_xform as gx

maps = np.array(
    [
        [[0.0, 0, 0], [0, 0.16, 0], [0, 0, 1]],
        [[0.85, 0.04, 0], [-0.04, 0.85, 1.6], [0, 0, 1]],
        [[0.2, -0.26, 0], [0.23, 0.22, 1.6], [0, 0, 1]],
        [[-0.15, 0.28, 0], [0.26, 0.24, 0.44], [0, 0, 1]],
    ]
)
rng = np.random.default_rng(0)
points = np.zeros((300_000, 2))
for _ in range(60):  # all points at once, each by a map of its own
    points = gx.transform_points(points, maps, index=rng.choice(4, len(points), p=[0.01, 0.85, 0.07, 0.07]))
fern = np.column_stack([points[:, 1], points[:, 0], 0 * points[:, 0]])
camera = gx.Camera.window((-0.5, 10.5), (-3.4, 3.4))
picture = gx.render(fern, scalars="x", cmap="YlGn_r", clim=(-2, 16), point_size=1.2, camera=camera, size=(960, 600))
picture.save("fern.png")
