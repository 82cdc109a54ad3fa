"""A Möbius strip.

One side, one edge: the boundary is a single closed line, drawn wider than the net.
"""

import gpu_xform as gx

strip = gx.samples.moebius(120, 10)
camera = {"direction": (-0.3, -0.75, -1)}
layers = [
    gx.Layer(strip, fill="#fdf1dc", shading="flat", color="#8a6d3b", line_width=0.8),
    gx.Layer(strip, edges="boundary", hidden="remove", color="#b03a2e", line_width=4),
]
picture = gx.render(layers, camera=camera, size=(960, 640))
picture.save("moebius.png")
