"""Pictures as lines instead of pixels: what was computed in two dimensions becomes SVG or PDF.

Reading order: decimal_text, join_segments, layer, paths, svg, pdf, edge_visibility, painters, clip_faces, fills,
build_layers.
"""

from .layer import Dots, Polygons, Strokes, dash_pattern
from .pdf import pdf
from .svg import svg

__all__ = ["Dots", "Polygons", "Strokes", "dash_pattern", "pdf", "svg"]
