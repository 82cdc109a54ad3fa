"""Model files: one module a format, each turning bytes into a mesh or a mesh into bytes.

Reading order: _concatenate, _text, _trimesh, npy, obj, off, ply, stl, vrml_syntax, vrml, gltf_meshes, gltf_nodes,
gltf, glb, threemf, registry.
"""

from .registry import load_mesh, load_scene, save_mesh

__all__ = ["load_mesh", "load_scene", "save_mesh"]
