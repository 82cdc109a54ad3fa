"""A city in parallel projection.

1,600 boxes, one mesh, one matrix per box; four greys, chosen by height.
"""

import numpy as np

import gpu_xform as gx

rng = np.random.default_rng(11)
x, z = (axis.ravel() for axis in np.meshgrid(np.arange(40.0), np.arange(40.0)))
center = np.hypot(x - 19.5, z - 19.5)
height = 0.4 + 7 * np.exp(-((center / 9) ** 2)) * rng.uniform(0.25, 1, x.shape) + rng.gamma(2, 0.25, x.shape)
keep = (x % 5 != 0) & (z % 7 != 0)
box = gx.samples.cube()
layers = []
for low, high, color in ((0, 1, "#dfe6ee"), (1, 2.2, "#b9cbdd"), (2.2, 4, "#8fb0d0"), (4, 99, "#f0b35a")):
    chosen = keep & (height >= low) & (height < high)
    places = np.array(
        [
            gx.chain(gx.scale(0.42, h / 2, 0.42), gx.translate(a, h / 2, b))
            for a, h, b in zip(x[chosen], height[chosen], z[chosen], strict=True)
        ]
    )
    layers.append(gx.Layer(box, transform=places, fill=color, shading="flat", color="#2b3440", line_width=0.7))
camera = {"direction": (-1, -0.75, -1), "orthographic": True, "margin": 0.01}
picture = gx.render(layers, camera=camera, size=(960, 640), background="#f7f8fa")
picture.save("city.png")
