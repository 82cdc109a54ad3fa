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
from .geometry.mesh import Mesh
from .geometry.scene import Scene
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

if TYPE_CHECKING:
    from .animation import Animation, animate, turntable
    from .compute.point_buffer import PointBuffer, bounds
    from .compute.streaming import transform_file
    from .compute.transform import project_points, transform_normals, transform_points, transform_vectors
    from .drawing.camera import Camera
    from .drawing.layer import Layer
    from .formats import load_mesh, load_scene, save_mesh
    from .gpu.adapters import adapters
    from .gpu.device import Device
    from .imaging.compare import compare_images
    from .rendering.raster import render, render_array
    from .rendering.vector import render_pdf, render_svg
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
    "Camera": ".drawing.camera",
    "Device": ".gpu.device",
    "Layer": ".drawing.layer",
    "PointBuffer": ".compute.point_buffer",
    "adapters": ".gpu.adapters",
    "animate": ".animation",
    "bounds": ".compute.point_buffer",
    "compare_images": ".imaging.compare",
    "load_mesh": ".formats",
    "load_scene": ".formats",
    "project_points": ".compute.transform",
    "render": ".rendering.raster",
    "render_array": ".rendering.raster",
    "render_pdf": ".rendering.vector",
    "render_svg": ".rendering.vector",
    "save_mesh": ".formats",
    "transform_file": ".compute.streaming",
    "transform_normals": ".compute.transform",
    "transform_points": ".compute.transform",
    "transform_vectors": ".compute.transform",
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
