"""Bulk homogeneous transforms and wireframe pictures on any GPU, or on none.

What needs no GPU is here at once; what opens a device, draws or reads files is imported when it is first named, so that
`import gpu_xform` costs no more than NumPy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import matrices, planar, samples
from .errors import (
    ArgumentError,
    ArgumentTypeError,
    DeviceError,
    DeviceMemoryError,
    DisplayError,
    GpuXformError,
    MeshError,
    MissingExtraError,
    NoAdapterError,
    PrecisionError,
    PrecisionWarning,
    ShaderError,
    SingularMatrixError,
    SizeWarning,
)
from .matrices import (
    chain,
    decompose,
    explain,
    homogeneous,
    identity,
    inverse,
    look_at,
    orthographic,
    perspective,
    perspective_from_eye,
    project_onto,
    reflect,
    rotate,
    rotate_x,
    rotate_y,
    rotate_z,
    scale,
    shear,
    translate,
)
from .mesh import Mesh
from .scene import Scene

if TYPE_CHECKING:
    from .animation import Animation, animate, turntable
    from .cameras import Camera
    from .comparison import compare_images
    from .formats import load_mesh, load_scene, save_mesh
    from .gpu.adapters import adapters
    from .gpu.device import Device
    from .pictures.layers import Layer
    from .pictures.vector_pictures import render_pdf, render_svg
    from .pictures.wireframe import render, render_array
    from .point_buffer import PointBuffer, bounds
    from .streaming import transform_file
    from .transform import project_points, transform_normals, transform_points, transform_vectors
    from .viewer.window import view

__version__ = "0.1.0"

__all__ = [
    "Animation",
    "ArgumentError",
    "ArgumentTypeError",
    "Camera",
    "Device",
    "DeviceError",
    "DeviceMemoryError",
    "DisplayError",
    "GpuXformError",
    "Layer",
    "Mesh",
    "MeshError",
    "MissingExtraError",
    "NoAdapterError",
    "PointBuffer",
    "PrecisionError",
    "PrecisionWarning",
    "Scene",
    "ShaderError",
    "SingularMatrixError",
    "SizeWarning",
    "adapters",
    "animate",
    "bounds",
    "chain",
    "compare_images",
    "decompose",
    "explain",
    "homogeneous",
    "identity",
    "inverse",
    "load_mesh",
    "load_scene",
    "look_at",
    "matrices",
    "orthographic",
    "perspective",
    "perspective_from_eye",
    "planar",
    "project_onto",
    "project_points",
    "reflect",
    "render",
    "render_array",
    "render_pdf",
    "render_svg",
    "rotate",
    "rotate_x",
    "rotate_y",
    "rotate_z",
    "samples",
    "save_mesh",
    "scale",
    "shear",
    "transform_file",
    "transform_normals",
    "transform_points",
    "transform_vectors",
    "translate",
    "turntable",
    "view",
]

_LATE = {
    "Animation": ".animation",
    "Camera": ".cameras",
    "Device": ".gpu.device",
    "Layer": ".pictures.layers",
    "PointBuffer": ".point_buffer",
    "adapters": ".gpu.adapters",
    "animate": ".animation",
    "bounds": ".point_buffer",
    "compare_images": ".comparison",
    "load_mesh": ".formats",
    "load_scene": ".formats",
    "project_points": ".transform",
    "render": ".pictures.wireframe",
    "render_array": ".pictures.wireframe",
    "render_pdf": ".pictures.vector_pictures",
    "render_svg": ".pictures.vector_pictures",
    "save_mesh": ".formats",
    "transform_file": ".streaming",
    "transform_normals": ".transform",
    "transform_points": ".transform",
    "transform_vectors": ".transform",
    "turntable": ".animation",
    "view": ".viewer.window",
}


def __getattr__(name: str) -> Any:
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_LATE[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
