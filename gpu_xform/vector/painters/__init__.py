"""Painter's algorithm for polygons in NumPy: clipping by planes, and sorting from back to front.

Reading order: ragged, polygons, clipping, overlaps, depth_graph, cycle_breaking, painters_algorithm.
"""

from .clipping import HalfSpace, clip, split_bands
from .painters_algorithm import sort_back_to_front
from .polygons import RaggedPolygons, concatenate, mean, min_max, select, triangulate_fans
from .ragged import rows_of

__all__ = [
    "HalfSpace",
    "RaggedPolygons",
    "clip",
    "concatenate",
    "mean",
    "min_max",
    "rows_of",
    "select",
    "sort_back_to_front",
    "split_bands",
    "triangulate_fans",
]
