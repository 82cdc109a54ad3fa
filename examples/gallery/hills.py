"""A function of two variables.

A net of quads in the colours of its height, with axes, a trail over it and a colour bar.
"""

from typing import Any

import numpy as np

import gpu_xform as gx


def height(x: Any, y: Any) -> Any:
    """Return the height of the hills."""
    return 1.4 * np.exp(-((x - 1) ** 2) - y**2) + 0.9 * np.exp(-0.7 * ((x + 1.2) ** 2 + (y - 1) ** 2))


hills = gx.parametric(lambda x, y: (x, y, height(x, y)), (-3, 3), (-2.5, 3), closed=(False, False), n=(54, 50))
x = np.linspace(-2.8, 2.6, 80)
y = 0.9 + 0.9 * np.sin(0.9 * x - 1)
trail = gx.Mesh(np.column_stack([x, y, height(x, y) + 0.02]), [(i, i + 1) for i in range(79)])
picture = gx.render(
    [
        gx.Layer(hills, fill="white", scalars="z", cmap="plasma", colorbar="height / km", line_width=1.3),
        gx.Layer(trail, color="#0b7d4f", line_width=4, labels={0: "start", -1: "end"}, hidden="remove"),
    ],
    camera={"up": (0, 0, 1), "direction": (-0.35, 1, -0.65)},
    axes=("east / km", "north / km", "up / km"),
    size=(960, 600),
)
picture.save("hills.png")
