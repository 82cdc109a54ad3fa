"""Model files: one module a format, each turning bytes into a mesh or a mesh into bytes."""

from .registry import load_mesh, load_scene, save_mesh

__all__ = ["load_mesh", "load_scene", "save_mesh"]
