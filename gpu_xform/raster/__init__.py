"""Draw lists to pixels: the rasterisers, what they share, and the choice among them.

Reading order: base, tiles, screen_bounds, tile_struct, quads, render_target, vertex_stage, line_batches, dashes,
triangles, binding_limits, line_stage, clouds, rasterizer, compute, hardware, names, workload, tuning, choose.
"""
