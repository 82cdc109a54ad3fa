"""A drawing with dashed hidden lines.

Feature edges and the silhouette in wide lines, what is hidden in narrow dashes, as technical drawings have them.
"""

from typing import Any

import numpy as np

import gpu_xform as gx


def ring(inner: float, outer: float, low: float, high: float, n: int = 72) -> gx.Mesh:
    """Return a ring about the z-axis."""
    angle = np.arange(n) * 2 * np.pi / n
    sides = [(outer, low), (outer, high), (inner, high), (inner, low)]
    points = np.vstack([np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle + z]) for r, z in sides])
    quads = [
        (k * n + i, k * n + (i + 1) % n, (k + 1) % 4 * n + (i + 1) % n, (k + 1) % 4 * n + i)
        for k in range(4)
        for i in range(n)
    ]
    return gx.Mesh(points, quads)


holes = [gx.translate(42 * np.cos(a), 42 * np.sin(a), 0) for a in np.arange(6) * np.pi / 3]
style: dict[str, Any] = {
    "edges": ["feature", "silhouette"],
    "hidden_style": {"line_width": 1, "dash": "02", "color": "#667"},
}
parts = [
    gx.Layer(ring(20, 56, 0, 10), line_width=2.2, **style),
    gx.Layer(ring(20, 27, 10, 44), line_width=2.2, **style),
    gx.Layer(ring(0.01, 5, 0, 10, 36), transform=np.array(holes), line_width=2.2, **style),
]
picture = gx.render(parts, camera={"direction": (-0.5, 1, -0.8), "up": (0, 0, 1)}, size=(960, 640))
picture.save("flange.png")
