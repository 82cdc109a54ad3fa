"""Curls.

300 simulated strands guide 6,000 others, which lie between them.
"""

import numpy as np

import gpu_xform as gx

hair = gx.samples.hair(300, 20, curls=3, length=0.3)
strands = gx.Springs(hair.mesh, **hair.springs(3, bend=0.5, core=1), mass=0.01, damping=3e-5, pinned=hair.roots)
head = gx.Sphere((0, 0, 0), 0.1, friction=0.2, gap=0.002)
path = strands.simulate(0.8, fps=10, drag_rate=1.5, obstacles=head)
coat = gx.ChildStrands(hair, 6000)
mesh = coat.meshes(path)[-1]
along = np.tile(np.linspace(0, 1, 20), len(mesh.positions) // 20)
ball = gx.Layer(gx.samples.icosphere(4), transform=gx.scale(0.1), fill="#e8c4a0", edges="silhouette", shading="flat")
locks = gx.Layer(mesh, scalars=along, cmap="copper", line_width=0.8, alpha=0.9, hidden="remove", depth_cue=0.4)
picture = gx.render([ball, locks], camera={"direction": (-0.3, -0.2, -1)}, size=(960, 640))
picture.save("hair.png")
