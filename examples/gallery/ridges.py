"""Ridges in the night.

One line per row of a landscape. Its faces have the colour of the sky, so that near ridges hide far ones.
"""

import numpy as np

import gpu_xform as gx

rng = np.random.default_rng(7)
n_rows, n_columns = 64, 300
x, y = np.meshgrid(np.linspace(-1.6, 1.6, n_columns), np.linspace(0, 2.6, n_rows))
peaks = rng.normal(0, 0.38, (n_rows, 14))
widths, heights = rng.uniform(0.03, 0.14, (2, n_rows, 14))
bumps = heights[..., None] * np.exp(-(((x[:, None] - peaks[..., None]) / widths[..., None]) ** 2))
z = 1.4 * bumps.sum(axis=1) * np.exp(-2.2 * x**2) + 0.008 * rng.normal(size=x.shape).cumsum(axis=1) * np.exp(-4 * x**2)

index = np.arange(x.size).reshape(x.shape)
quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1).reshape(-1, 4)
rows = np.stack([index[:, :-1], index[:, 1:]], axis=-1).reshape(-1, 2)
land = gx.Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), quads)
picture = gx.render(
    land,
    edges=rows,
    fill="#0b0d14",
    color="#f2efe6",
    hidden="remove",
    line_width=1.6,
    background="#0b0d14",
    camera={"direction": (0, 1, -0.75), "up": (0, 0, 1), "orthographic": True, "margin": 0.12},
    size=(960, 640),
)
picture.save("ridges.png")
