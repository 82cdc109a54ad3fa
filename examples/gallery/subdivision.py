"""A smooth surface in its cage.

Catmull and Clark's subdivision of a few quads, three times; the cage is drawn around it.
"""

import gpu_xform as gx

cage = gx.samples.torus(7, 4)
smooth = gx.subdivide(cage, 3).mesh
camera = {"direction": (-0.4, -0.8, -1)}
layers = [
    gx.Layer(smooth, fill="#bcd7c4", shading="flat", color="#2f5d43", line_width=0.6),
    gx.Layer(cage, color="#c0392b", line_width=2, point_size=7),
]
picture = gx.render(layers, camera=camera, size=(960, 640))
picture.save("subdivision.png")
