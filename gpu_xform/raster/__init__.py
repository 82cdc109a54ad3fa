"""Draw lists to pixels: the rasterisers, what they share, and the choice among them.

Reading order: base, tiles, screen_bounds, compute, choose.
"""
