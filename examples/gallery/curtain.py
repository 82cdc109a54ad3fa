"""A curtain in the wind.

Its upper edge is pinned to a rail; a wind blows it into the room.
"""

import numpy as np

import gpu_xform as gx

curtain = gx.samples.curtain(72, 48, width=1.2, height=0.8, pleats=9)
top = np.flatnonzero(curtain.positions[:, 1] > curtain.positions[:, 1].max() - 1e-6)
springs = gx.Springs(curtain, mass=0.15, stretch=60, shear=6, bend=0.05, damping=3e-4, pinned=top)
path = springs.simulate(0.8, fps=20, drag=1.2, wind=(0.4, 0.0, 1.6))
picture = gx.render(
    path.meshes()[-1],
    fill="#b5394a",
    shading="flat",
    color="#5c1420",
    line_width=0.4,
    camera={"direction": (-0.7, -0.2, -1)},
    size=(960, 640),
)
picture.save("curtain.png")
