"""Smooth surfaces and curves as meshes: Bézier patches.

Reading order: bernstein, control_points, resolution, weld, patch_normals, patches, curves, newell_teapot.
"""
