"""The rasteriser that is made of compute shaders.

Reading order: tile_struct, render_target, vertex_stage, line_batches, triangles, binding_limits, lines, rasterizer.
"""
