"""Bulk homogeneous transforms and wireframe pictures on any GPU, or on none.

A public name is imported when it is first used, so that `import gpu_xform` costs next to nothing.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._core.moved_module import MovedModule

__version__ = "0.1.0"

# The public names, by the module that defines them; a module's own name stands for the module itself.
_PUBLIC_NAMES = {
    "errors": (
        "errors ArgumentError ArgumentTypeError ChunkWarning DeviceError DeviceMemoryError DeviceWarning "
        "DisplayError GpuXformError MeshError MeshWarning MissingExtraError NoAdapterError PrecisionError "
        "PrecisionWarning ShaderError SimulationError SimulationWarning SingularMatrixError SizeWarning TextWarning"
    ),
    "device": "Device default_device",
    "matrices": (
        "matrices chain decompose explain homogeneous identity inverse look_at orthographic perspective "
        "perspective_from_eye project_onto reflect rotate rotate_x rotate_y rotate_z scale shear translate"
    ),
    "planar": "planar",
    "surfaces.patches": "bezier",
    "surfaces.curves": "curve",
    "surfaces.bsplines": "bspline_to_bezier",
    "surfaces.function_surfaces": "parametric",
    "surfaces.subdivision": "Subdivision subdivide",
    "samples": "samples",
    "geometry.attributes": "Attributes RaggedArray",
    "geometry.mesh": "Mesh",
    "geometry.scene": "Scene",
    "geometry.strands": "Strands",
    "formats": "load_mesh load_scene save_mesh",
    "formats.limits": "FileLimits",
    "imaging.compare": "compare_images",
    "gpu.adapters": "adapters",
    "compute.transform": "project_points transform_normals transform_points transform_vectors",
    "compute.point_buffer": "PointBuffer bounds",
    "compute.mesh_buffer": "MeshBuffer",
    "compute.streaming": "transform_file",
    "compute.convolution.filters": "box_kernel gaussian sobel_kernel",
    "compute.convolution.convolve": "convolve correlate",
    "dask": "dask",
    "simulation.children": "ChildStrands",
    "simulation.obstacles": "Box Capsule HalfSpace Sphere",
    "simulation.springs": "Springs",
    "simulation.trajectory": "Trajectory",
    "drawing.camera": "Camera",
    "drawing.layer": "Layer",
    "rendering.raster": "render render_array",
    "rendering.vector": "render_pdf render_svg",
    "vector.svg_text": "SvgText",
    "animation": "Animation animate turntable",
    "viewer.window": "view",
    "web.page": "save_page",
}
_MODULES = {name: module for module, names in _PUBLIC_NAMES.items() for name in names.split()}

__all__ = sorted(_MODULES.keys() - {"errors"})  # an attribute, but its classes are all here

# Where pickles of earlier versions look for classes.
_MOVED_MODULES = {
    "mesh": "geometry.mesh",
    "pictures": "drawing",
    "pictures.layers": "drawing.layer",
    "scene": "geometry.scene",
}
sys.modules.update(
    {f"{__name__}.{old}": MovedModule(f"{__name__}.{old}", f"{__name__}.{new}") for old, new in _MOVED_MODULES.items()}
)

if TYPE_CHECKING:
    from . import dask as dask
    from . import errors as errors
    from . import matrices as matrices
    from . import planar as planar
    from . import samples as samples
    from .animation import Animation as Animation
    from .animation import animate as animate
    from .animation import turntable as turntable
    from .compute.convolution.convolve import convolve as convolve
    from .compute.convolution.convolve import correlate as correlate
    from .compute.convolution.filters import box_kernel as box_kernel
    from .compute.convolution.filters import gaussian as gaussian
    from .compute.convolution.filters import sobel_kernel as sobel_kernel
    from .compute.mesh_buffer import MeshBuffer as MeshBuffer
    from .compute.point_buffer import PointBuffer as PointBuffer
    from .compute.point_buffer import bounds as bounds
    from .compute.streaming import transform_file as transform_file
    from .compute.transform import project_points as project_points
    from .compute.transform import transform_normals as transform_normals
    from .compute.transform import transform_points as transform_points
    from .compute.transform import transform_vectors as transform_vectors
    from .device import Device as Device
    from .device import default_device as default_device
    from .drawing.camera import Camera as Camera
    from .drawing.layer import Layer as Layer
    from .errors import ArgumentError as ArgumentError
    from .errors import ArgumentTypeError as ArgumentTypeError
    from .errors import ChunkWarning as ChunkWarning
    from .errors import DeviceError as DeviceError
    from .errors import DeviceMemoryError as DeviceMemoryError
    from .errors import DeviceWarning as DeviceWarning
    from .errors import DisplayError as DisplayError
    from .errors import GpuXformError as GpuXformError
    from .errors import MeshError as MeshError
    from .errors import MeshWarning as MeshWarning
    from .errors import MissingExtraError as MissingExtraError
    from .errors import NoAdapterError as NoAdapterError
    from .errors import PrecisionError as PrecisionError
    from .errors import PrecisionWarning as PrecisionWarning
    from .errors import ShaderError as ShaderError
    from .errors import SimulationError as SimulationError
    from .errors import SimulationWarning as SimulationWarning
    from .errors import SingularMatrixError as SingularMatrixError
    from .errors import SizeWarning as SizeWarning
    from .errors import TextWarning as TextWarning
    from .formats import load_mesh as load_mesh
    from .formats import load_scene as load_scene
    from .formats import save_mesh as save_mesh
    from .formats.limits import FileLimits as FileLimits
    from .geometry.attributes import Attributes as Attributes
    from .geometry.attributes import RaggedArray as RaggedArray
    from .geometry.mesh import Mesh as Mesh
    from .geometry.scene import Scene as Scene
    from .geometry.strands import Strands as Strands
    from .gpu.adapters import adapters as adapters
    from .imaging.compare import compare_images as compare_images
    from .matrices import chain as chain
    from .matrices import decompose as decompose
    from .matrices import explain as explain
    from .matrices import homogeneous as homogeneous
    from .matrices import identity as identity
    from .matrices import inverse as inverse
    from .matrices import look_at as look_at
    from .matrices import orthographic as orthographic
    from .matrices import perspective as perspective
    from .matrices import perspective_from_eye as perspective_from_eye
    from .matrices import project_onto as project_onto
    from .matrices import reflect as reflect
    from .matrices import rotate as rotate
    from .matrices import rotate_x as rotate_x
    from .matrices import rotate_y as rotate_y
    from .matrices import rotate_z as rotate_z
    from .matrices import scale as scale
    from .matrices import shear as shear
    from .matrices import translate as translate
    from .rendering.raster import render as render
    from .rendering.raster import render_array as render_array
    from .rendering.vector import render_pdf as render_pdf
    from .rendering.vector import render_svg as render_svg
    from .simulation.children import ChildStrands as ChildStrands
    from .simulation.obstacles import Box as Box
    from .simulation.obstacles import Capsule as Capsule
    from .simulation.obstacles import HalfSpace as HalfSpace
    from .simulation.obstacles import Sphere as Sphere
    from .simulation.springs import Springs as Springs
    from .simulation.trajectory import Trajectory as Trajectory
    from .surfaces.bsplines import bspline_to_bezier as bspline_to_bezier
    from .surfaces.curves import curve as curve
    from .surfaces.function_surfaces import parametric as parametric
    from .surfaces.patches import bezier as bezier
    from .surfaces.subdivision import Subdivision as Subdivision
    from .surfaces.subdivision import subdivide as subdivide
    from .vector.svg_text import SvgText as SvgText
    from .viewer.window import view as view
    from .web.page import save_page as save_page
else:

    def __getattr__(name: str) -> Any:
        """Import a public name, which is an attribute from then on."""
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from ._core.interrupts import defer_interrupts

        with defer_interrupts():  # NumPy, half imported, would stay broken
            module = import_module(f".{_MODULES[name]}", __name__)
        value = module if name == _MODULES[name] else getattr(module, name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*__all__, "errors", *(name for name in globals() if name.startswith("__"))})
