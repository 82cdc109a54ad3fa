"""A village of one house.

Sixty instances of a mesh that is uploaded once: one matrix each, and a fill per instance by layers.
"""

import numpy as np

import gpu_xform as gx

rng = np.random.default_rng(4)
colors = ("#d9c2a0", "#c9d4c0", "#d8b4a0", "#bfcad8")
places: dict[str, list[np.ndarray]] = {color: [] for color in colors}
for row in range(6):
    for column in range(10):
        size = gx.scale(rng.uniform(0.8, 1.1), rng.uniform(0.7, 1.7), rng.uniform(0.8, 1.2))
        turn = gx.rotate_y(rng.uniform(-25, 25), degrees=True)
        spot = gx.translate(3.6 * column + rng.uniform(-0.4, 0.4), 0, 4.2 * row)
        places[colors[rng.integers(4)]].append(gx.chain(gx.translate(0, 1, 0), size, turn, spot))
layers = [
    gx.Layer(
        gx.samples.house(), transform=np.array(matrices), fill=color, shading="flat", color="#3c3836", line_width=1.2
    )
    for color, matrices in places.items()
]
picture = gx.render(layers, camera={"direction": (-0.45, -0.7, -1), "margin": 0.02}, size=(960, 560))
picture.save("village.png")
