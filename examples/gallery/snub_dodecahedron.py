"""A colour per face.

A ball of 80 triangles and 12 pentagons: every face keeps its corners, and each outline has the colour of its face.
"""

import gpu_xform as gx

ball = gx.samples.snub_dodecahedron()
camera = gx.Camera.window((-3.6, 3.6), (-2.4, 2.4))
picture = gx.render(ball, color="face", line_width=4, hidden="remove", camera=camera, size=(960, 640))
picture.save("snub_dodecahedron.png")
