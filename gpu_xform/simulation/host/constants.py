"""What the loops and their twins in NumPy share: the order of numbers in the arrays that they take."""

import numpy as np

# Of the numbers of a step.
KICK_S, DRIFT_S = 0, 1
GRAVITY, WIND = 2, 5  # three each
DRAG_RATE, FACE_DRAG, DAMPING_S, FRAME_PART = 8, 9, 10, 11
N_CONSTANTS = 12

# Of the numbers of an obstacle, as in `layouts.OBSTACLE`.
ROTATION_BEFORE, ROTATION_AFTER = 0, 4
CENTER_BEFORE, FRICTION, CENTER_AFTER, GAP = 8, 11, 12, 15
HALF_SIZE, RADIUS, VELOCITY, IS_HALF_SPACE, ANGULAR_VELOCITY = 16, 19, 20, 23, 24

# float32, as Python's own numbers would make float64 of everything.
ZERO, ONE, TWO, THREE = (np.float32(number) for number in (0.0, 1.0, 2.0, 3.0))
TINY = np.float32(1e-30)  # m^2, so that a slot without a spring divides by no zero
