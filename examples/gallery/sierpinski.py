"""A pyramid of pyramids.

Five times, four half-size copies replace each tetrahedron: 1,024 instances of one mesh, one matrix each.
"""

import numpy as np

import gpu_xform as gx

corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
halves = np.stack([gx.scale(0.5) @ gx.translate(*corner) for corner in corners])
places = np.eye(4)[None]
for _ in range(5):
    places = (halves[:, None] @ places[None]).reshape(-1, 4, 4)
solid = gx.Mesh(corners, [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
picture = gx.render(
    solid,
    transform=places,
    fill="#f2b134",
    shading="flat",
    line_width=0.6,
    color="#6b4a00",
    camera={"direction": (-0.35, -0.5, -1)},
    size=(960, 640),
)
picture.save("sierpinski.png")
