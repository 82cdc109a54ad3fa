"""Meshes, their triangles and edges, and scenes: plain data, NumPy alone.

Reading order: attributes, triangulation, mesh, strands, edges, chains, box_tree, intersections, deformable_mesh,
scene_animation, scene.
"""
