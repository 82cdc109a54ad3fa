"""Polygons cut by planes, and put in the order in which a painter lays them: NumPy only.

Reading order: ragged, polygons, clipping, box_tree, overlaps, depth_graph, cycle_breaking, painters_algorithm.
"""

from .clipping import Height, clipped, strips
from .painters_algorithm import painters_order
from .polygons import Pieces, chosen, extremes, fans, means, together
from .ragged import members

__all__ = [
    "Height",
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
