"""A reach, as one picture.

Seven poses of a robot arm; each joint moves all that is attached to it. Earlier poses are fainter.
"""

import numpy as np

import gpu_xform as gx

arm = gx.samples.robot_arm()
ghosts = []
for t in np.linspace(0, 1, 7):
    turns = {"upper arm": 50 - 75 * t, "forearm": -100 + 70 * t, "hand": -35 + 50 * t}
    posed = arm.posed(
        {joint: arm[joint].transform @ gx.rotate_z(angle, degrees=True) for joint, angle in turns.items()}
    )
    for layer in posed.layers():
        faint = gx.Layer(
            layer.model,
            transform=layer.transform,
            hidden="remove",
            edges=["feature", "silhouette"],
            color="#1f3a5f",
            alpha=0.12 + 0.88 * t**2,
            line_width=1 + 1.2 * t,
        )
        ghosts.append(faint)
picture = gx.render(ghosts, camera={"direction": (-0.35, -0.3, -1)}, size=(960, 640))
picture.save("robot_arm.png")
