"""Contour by contour.

A saddle in flat bands of colour: a colormap may be any function of a number.
"""

import numpy as np

import gpu_xform as gx

saddle = gx.samples.saddle(80)
low, high = saddle.positions[:, 1].min(), saddle.positions[:, 1].max()
centers = np.array([saddle.positions[list(face), 1].mean() for face in saddle.faces])
bands = np.floor(14 * (centers - low) / (high - low + 1e-9)) / 13
warm, cold = np.array([0.85, 0.35, 0.2]), np.array([0.15, 0.35, 0.65])
colors = bands[:, None] * warm + (1 - bands[:, None]) * cold
picture = gx.render(
    saddle,
    fill=0.35 + 0.65 * colors,
    shading="flat",
    edges="boundary",
    line_width=3,
    size=(960, 640),
    camera={"direction": (-0.5, -0.6, -1)},
)
picture.save("saddle.png")
