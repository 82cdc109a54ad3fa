"""Meshes, their triangles and edges, and scenes: plain data, NumPy alone.

Reading order: attributes, triangulation, face_list, mesh, strands, edges, components, corner_normals, chains, box_tree,
intersections, sections, section_areas, mesh_copies, deformable_mesh, foreign_meshes, trimesh_scenes, scene_animation,
joints, nodes, instances, scene.
"""
