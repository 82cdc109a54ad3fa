"""Sample models for pictures and tests: meshes computed from their geometry, and a scene of meshes.

All faces are counter-clockwise as seen from outside, if there is an outside.

Reading order: _arguments, _polyhedra, _cloth_and_hair, _curved, _robot.
"""

from ._cloth_and_hair import cloth, curtain, grid, hair
from ._curved import klein_bottle, moebius, saddle, teapot, teapot_patches, torus, trefoil_tube
from ._polyhedra import cube, house, icosphere, snub_dodecahedron
from ._robot import robot_arm

__all__ = [
    "cloth",
    "cube",
    "curtain",
    "grid",
    "hair",
    "house",
    "icosphere",
    "klein_bottle",
    "moebius",
    "robot_arm",
    "saddle",
    "snub_dodecahedron",
    "teapot",
    "teapot_patches",
    "torus",
    "trefoil_tube",
]


def __dir__() -> list[str]:
    return __all__
