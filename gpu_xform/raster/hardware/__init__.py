"""Lines by the rasteriser in hardware.

Reading order: edge_lists, lines.
"""
