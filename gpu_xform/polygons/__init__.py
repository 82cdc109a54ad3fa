"""Polygons cut by planes, and put in the order in which a painter lays them: NumPy only."""

from .clipping import Height, clipped, strips
from .groups import Flags, Indices, members
from .order import painters_order
from .pieces import Pieces, chosen, extremes, fans, means, together

__all__ = [
    "Flags",
    "Height",
    "Indices",
    "Pieces",
    "chosen",
    "clipped",
    "extremes",
    "fans",
    "means",
    "members",
    "painters_order",
    "strips",
    "together",
]
