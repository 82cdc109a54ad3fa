"""Vectors on a surface.

Normals as arrows: `transform_normals` keeps them perpendicular when the ball is squeezed.
"""

import numpy as np

import gpu_xform as gx

ball = gx.samples.icosphere(3)
squeeze = gx.chain(gx.scale(1.5, 0.7, 1), gx.shear(xy=0.5))
normals = gx.transform_normals(ball.positions, squeeze)
normals /= np.linalg.norm(normals, axis=1, keepdims=True)
feet = gx.transform_points(ball.positions, squeeze)
n = len(feet)
arrows = gx.Mesh(np.vstack([feet, feet + 0.22 * normals]), np.column_stack([np.arange(n), np.arange(n) + n]))
layers = [
    gx.Layer(ball, transform=squeeze, fill="#eef2f7", shading="flat", color="#9fb0c3", line_width=0.6),
    gx.Layer(arrows, scalars=np.tile(normals[:, 1], 2), cmap="coolwarm", line_width=2, hidden="remove"),
]
picture = gx.render(layers, camera={"direction": (-0.4, -0.35, -1)}, size=(960, 600))
picture.save("normals.png")
