"""Smooth surfaces and curves as meshes: Bézier patches, B-splines, functions of two parameters, and subdivision.

Reading order: bernstein, control_points, resolution, weld, patch_grids, patch_normals, patches, curves,
function_surfaces, bsplines, newell_teapot, cage, refine, subdivision.
"""
