"""Near and far.

Five equal cubes, each four units behind the last, seen from an eye on the z-axis; hidden edges fade.
"""

import numpy as np

import gpu_xform as gx

places = np.stack([gx.translate(3.4 * i - 3.2, 1.5 * i - 1.2, -4 * i) for i in range(5)])
camera = gx.Camera.eye_on_z(8, (-5.4, 5.4), (-2.9, 3.85))
picture = gx.render(
    gx.samples.cube(), transform=places, camera=camera, hidden="fade", line_width=2.5, color="#1f3a5f", size=(960, 600)
)
picture.save("cubes_in_perspective.png")
