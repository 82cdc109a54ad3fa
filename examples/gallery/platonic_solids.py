"""The five regular solids.

They are hulls of their corners, filled, shaded by a lamp at the eye, and named.
"""

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

import gpu_xform as gx

PHI = (1 + 5**0.5) / 2
even = [(x, y, z) for x, y, z in product((-1, 1), repeat=3) if x * y * z > 0]
axes = np.vstack([np.eye(3), -np.eye(3)])
rectangles = [(0, a, b * PHI) for a, b in product((-1, 1), repeat=2)]
golden = [(0, a / PHI, b * PHI) for a, b in product((-1, 1), repeat=2)]
corners = {
    "tetrahedron": even,
    "cube": list(product((-1, 1), repeat=3)),
    "octahedron": axes,
    "dodecahedron": [*product((-1, 1), repeat=3), *(np.roll(p, k) for p in golden for k in range(3))],
    "icosahedron": [np.roll(p, k) for p in rectangles for k in range(3)],
}
layers = []
for i, (name, points) in enumerate(corners.items()):
    ball = np.array(points, float)
    ball /= np.linalg.norm(ball[0])
    faces = []
    for triangle in ConvexHull(ball).simplices:
        inward = np.linalg.det(ball[triangle]) < 0
        faces.append(triangle[::-1] if inward else triangle)
    place = gx.chain(gx.rotate_y(20, degrees=True), gx.translate(2.3 * i, 0, 0))
    color = ("#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#b07aa1")[i]
    layers.append(
        gx.Layer(
            gx.Mesh(ball, faces),
            transform=place,
            edges="feature",
            feature_angle=5,
            fill=color,
            shading="flat",
            color="white",
            line_width=2,
        )
    )
    label = gx.Layer(np.array([(2.3 * i - 0.75, -1.4, 0.0)]), labels={0: name}, point_size=0.1, color="#333333")
    layers.append(label)
picture = gx.render(layers, camera={"direction": (0, -0.25, -1)}, size=(960, 320), font_size=20)
picture.save("platonic_solids.png")
