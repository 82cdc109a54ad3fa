"""Where bodies meet.

A ball and two tubes penetrate one another; the lines where they do are found, and drawn like all others.
"""

import gpu_xform as gx

ball, torus = gx.samples.icosphere(5), gx.samples.torus(160, 48)
bodies = [
    (ball, gx.scale(0.62), "#f4d9a8"),
    (torus, gx.chain(gx.rotate_x(75, degrees=True), gx.scale(0.6), gx.translate(-0.35, 0, 0)), "#cfe0ee"),
    (torus, gx.chain(gx.rotate_y(35, degrees=True), gx.scale(0.6), gx.translate(0.4, 0.1, 0)), "#d9ead6"),
]
layers = [
    gx.Layer(body, transform=place, fill=color, edges=["silhouette", "intersection"], line_width=2.5, color="#34495e")
    for body, place, color in bodies
]
picture = gx.render(layers, camera={"direction": (-0.5, -0.55, -1)}, size=(960, 640))
picture.save("intersection.png")
