"""A bend and a twist by weights.

Each point of a bar moves by its own mixture of two matrices, as the skin of a figure does between two bones.
"""

import numpy as np

import gpu_xform as gx

n = 60
ring = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * 0.5
points = np.array([(4 * i / n - 2, a, b) for i in range(n + 1) for a, b in ring])
faces = [(4 * i + k, 4 * i + (k + 1) % 4, 4 * i + 4 + (k + 1) % 4, 4 * i + 4 + k) for i in range(n) for k in range(4)]
share = 0.5 + 0.5 * np.tanh(2 * points[:, 0])
bones = np.array([gx.identity(), gx.chain(gx.rotate_x(80, degrees=True), gx.rotate_z(75, degrees=True))])
skin = gx.transform_points(
    points, bones, index=np.tile([0, 1], (len(points), 1)), weights=np.column_stack([1 - share, share])
)
picture = gx.render(
    gx.Mesh(skin, faces),
    fill="white",
    scalars=share,
    cmap="plasma",
    line_width=1.6,
    camera={"direction": (-0.3, -0.4, -1)},
    size=(960, 600),
)
picture.save("skinning.png")
