"""An arm that waves.

A scene of four nodes; a dict of matrices per frame moves its joints.
"""

import numpy as np

import gpu_xform as gx

arm = gx.samples.robot_arm()
frames = []
for t in np.linspace(0, 2 * np.pi, 48, endpoint=False):
    turns = {"upper arm": 35 * np.sin(t), "forearm": -60 - 30 * np.sin(t), "hand": 40 * np.sin(2 * t)}
    frames.append({name: arm[name].transform @ gx.rotate_z(turn, degrees=True) for name, turn in turns.items()})
gx.animate(arm, frames, "waving_arm.webp", fps=16, size=(480, 320), hidden="remove", color="#1f3a5f")
