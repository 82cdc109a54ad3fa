"""A scan of a landscape.

400,000 points, as an aeroplane's laser leaves them, in the colours of their height; far points fade.
"""

import numpy as np

import gpu_xform as gx

rng = np.random.default_rng(7)
x, y = rng.uniform(-1, 1, (2, 400_000))
z = np.zeros_like(x)
for octave in range(1, 7):  # hills upon hills, each half as high as the last
    for _ in range(3):
        angle, phase = rng.uniform(0, 2 * np.pi, 2)
        wave = np.sin(2.1**octave * (np.cos(angle) * x + np.sin(angle) * y) + phase)
        z += 0.28 * 0.5**octave * (1 - np.abs(wave)) ** 1.5
points = np.column_stack([x, y, z + rng.normal(0, 0.002, z.shape)])
picture = gx.render(
    points,
    scalars="z",
    cmap="gist_earth",
    clim=(z.min() - 0.05, z.max() + 0.12),
    camera={"up": (0, 0, 1), "direction": (0.4, 1, -0.75), "margin": 0.01},
    depth_cue=0.4,
    point_size=2.4,
    background="#0e1420",
    size=(960, 600),
)
picture.save("terrain_scan.png")
