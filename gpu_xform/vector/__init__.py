"""Vector back end: a draw list becomes SVG or PDF.

Reading order: decimal_text, join_segments, layer, coincident, paths, annotation_svg, svg, svg_text, annotation_pdf,
gouraud, pdf, edge_visibility, painters, nonplanar, clip_faces, lit_triangles, fills, sort_fills, build_layers.
"""

from .layer import Points, Polygons, Stroke, VectorLayer
from .pdf import format_pdf
from .svg import format_svg

__all__ = ["Points", "Polygons", "Stroke", "VectorLayer", "format_pdf", "format_svg"]
