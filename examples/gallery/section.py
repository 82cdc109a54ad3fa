"""A section with hatching.

Three shells, one in another, cut by a plane: what lies before it is removed, and each wall is hatched the other way.
"""

from typing import Any

import gpu_xform as gx

ball = gx.samples.icosphere(5)
cut: dict[str, Any] = {"section": ((0, 0.12, 0), (0.35, 1, 0.45)), "edges": "silhouette", "line_width": 2}
shells = [
    gx.Layer(ball, transform=gx.scale(radius), fill=color, hatch=(angle, spacing), **cut)
    for radius, color, angle, spacing in (
        (1, "#f3e3c3", 45, 0.09),
        (0.78, "#cfe0ee", 135, 0.09),
        (0.5, "#f1c8b8", 45, 0.05),
    )
]
picture = gx.render(shells, camera={"direction": (-0.5, -0.5, -1)}, size=(960, 640))
picture.save("section.png")
