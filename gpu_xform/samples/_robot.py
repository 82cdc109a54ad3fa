"""A scene whose parts move one another."""

import math

import numpy as np

from ..geometry.scene import Scene
from ..matrices import translate
from ._polyhedra import make_prism


def robot_arm() -> Scene:
    """Return a robot arm that stands on the xz-plane, straight up along y.

    "base" is the parent of "upper arm", that of "forearm", and that of "hand". Each part rotates about the z-axis of
    its own frame: `arm["forearm"].transform @ rotate_z(angle)` bends the elbow. The shoulder is at y = 0.9, the elbow
    at 2.9, the wrist at 4.5.

    Returns
    -------
    Scene
    """
    half_turn = np.linspace(0.0, math.pi, 7)
    above = 0.3 * np.column_stack([np.cos(half_turn), np.sin(half_turn)])
    below = -above
    # Each moving part lies between two plates of its parent.
    inside, plates = (-0.14, 0.14), ((-0.3, -0.16), (0.16, 0.3))
    arm = Scene()
    base = arm.add(make_prism([(-1.0, 0.0), (1.0, 0.0), (1.0, 0.3), (-1.0, 0.3)], -1.0, 1.0), name="base")
    for plate in plates:
        base.show(make_prism([(-0.3, 0.3), (0.3, 0.3), *np.add(above, (0.0, 0.9))], *plate))
    upper_arm = arm.add(name="upper arm", parent=base, transform=translate(0.0, 0.9, 0.0))
    upper_arm.show(make_prism([*below, *np.add(above, (0.0, 2.0))], *inside))
    forearm = arm.add(name="forearm", parent=upper_arm, transform=translate(0.0, 2.0, 0.0))
    for plate in plates:
        forearm.show(make_prism([*below, *np.add(above, (0.0, 1.6))], *plate))
    hand = arm.add(name="hand", parent=forearm, transform=translate(0.0, 1.6, 0.0))
    right = [(0.3, 0.4), (0.45, 0.5), (0.45, 1.1), (0.3, 1.1), (0.3, 0.6)]
    hand.show(make_prism([*below, *right, *((-x, y) for x, y in reversed(right))], *inside))
    return arm
