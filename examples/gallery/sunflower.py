"""Seeds of a sunflower.

700 spheres at the golden angle, their sizes and colours by their distance from the centre.
"""

import numpy as np

import gpu_xform as gx

n = 700
k = np.arange(n)
angle, radius = k * np.pi * (3 - 5**0.5), np.sqrt(k / n)
seed = gx.samples.icosphere(1)
layers = []
for ring in range(12):
    chosen = k[(12 * radius).astype(int) == ring]
    places = [
        gx.chain(
            gx.scale(0.016 + 0.016 * radius[i]),
            gx.translate(radius[i] * np.cos(angle[i]), 0.2 * (1 - radius[i] ** 2), radius[i] * np.sin(angle[i])),
        )
        for i in chosen
    ]
    share = ring / 11
    color = (0.35 + 0.6 * share, 0.2 + 0.55 * share, 0.08)
    layers.append(
        gx.Layer(seed, transform=np.array(places), fill=color, shading="flat", edges="silhouette", line_width=0.7)
    )
picture = gx.render(layers, camera={"direction": (0.1, -1, -0.6), "margin": 0.02}, size=(960, 640))
picture.save("sunflower.png")
