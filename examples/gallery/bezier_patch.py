"""A patch and its control points.

Sixteen control points, joined by a net in grey, and the surface that they pull towards them.
"""

import numpy as np

import gpu_xform as gx

y, x = np.meshgrid(np.arange(4), np.arange(4))
heights = np.array([(0, 1, 1, 0), (0, 2.6, -1, 0), (1, 1, 3, 1), (0, 0, 1.5, 0)])
patch = np.stack([x, heights, -y], axis=-1).astype(float)
number = np.arange(16).reshape(4, 4)
pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
net = gx.Mesh(patch.reshape(-1, 3), np.concatenate([np.stack(pair, axis=-1).reshape(-1, 2) for pair in pairs]))
surface = gx.bezier(patch, 20)
layers = [
    gx.Layer(surface, fill="white", scalars="y", cmap="viridis", line_width=1.5),
    gx.Layer(net, color="#8a8f98", line_width=1.5, point_size=9),
]
picture = gx.render(layers, camera={"direction": (-0.45, -0.5, -1)}, size=(960, 640))
picture.save("bezier_patch.png")
