"""Lines by the rasteriser in hardware.

Reading order: lines.
"""
