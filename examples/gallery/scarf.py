"""A scarf over a ball.

A cloth of springs falls and folds; Newton's and Hooke's laws move its 3,249 points on the device.
"""

import gpu_xform as gx

center, radius = (0.04, -0.25, -0.03), 0.24
cloth = gx.samples.cloth(56, 56).transformed(gx.rotate_y(25, degrees=True))
springs = gx.Springs(cloth, mass=0.06, stretch=40, shear=4, bend=0.1, damping=2e-4)
path = springs.simulate(1.3, fps=20, drag=1.0, obstacles=gx.Sphere(center, radius, friction=0.3, gap=0.006))
picture = gx.render(
    path.meshes()[-1],
    fill="#f6f8fb",
    shading="flat",
    color="#1f3a5f",
    line_width=0.9,
    camera={"direction": (-0.6, -0.55, -1)},
    size=(960, 720),
)
picture.save("scarf.png")
