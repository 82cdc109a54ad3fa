"""Meshes, their triangles and edges, and scenes: plain data, NumPy alone.

Reading order: triangulation, mesh, edges, scene.
"""
