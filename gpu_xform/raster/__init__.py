"""Draw lists to pixels.

Reading order: tiles, screen_bounds, compute.
"""
