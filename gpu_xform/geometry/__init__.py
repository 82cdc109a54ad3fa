"""Meshes, their triangles and edges, and scenes: plain data, NumPy alone.

Reading order: attributes, triangulation, mesh, edges, scene.
"""
