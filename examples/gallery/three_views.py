"""Three views and an isometric one.

One keyword, `views`, lays them out on a sheet, aligned and at one scale; what is hidden is dashed.
"""

from typing import Any

import gpu_xform as gx

style: dict[str, Any] = {"edges": ["feature", "silhouette", "intersection"], "hidden": "dash", "line_width": 2}
building = gx.Scene()
building.add(gx.samples.house(), **style)
porch, chimney = gx.chain(gx.scale(0.3, 0.45, 0.35), gx.translate(0.35, -0.55, 1.35)), gx.scale(0.16, 0.4, 0.16)
building.add(gx.samples.cube(), transform=porch, **style)
building.add(gx.samples.cube(), transform=gx.chain(chimney, gx.translate(0.5, 0.9, -0.3)), **style)
picture = gx.render(building, views="front,top,right,iso", size=(960, 720))
picture.save("three_views.png")
