"""Model files: one module a format, each turning bytes into a mesh or a mesh into bytes."""

from .registry import load_mesh, save_mesh

__all__ = ["load_mesh", "save_mesh"]
