"""Wireframe pictures: a mesh, transformed and projected on the device, its edges drawn offscreen."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import images
from ._arguments import Float64Array, MatrixLike, number, square_matrix
from .cameras import Camera
from .colors import FACE_CYCLE, ColorLike, packed, rgba
from .errors import ArgumentError, ArgumentTypeError, MeshError
from .gpu import line_pass
from .gpu.device import Device, default_device
from .mesh import Mesh

if TYPE_CHECKING:
    from PIL.Image import Image

Model = Mesh | str | os.PathLike[str]
Size = Sequence[int]

WIDEST_LINE = 1e6  # beyond that single precision loses the line's rim


def render(
    model: Model,
    *,
    transform: MatrixLike | None = None,
    camera: Camera | None = None,
    size: Size = (1024, 1024),
    line_width: float = 1.5,
    color: ColorLike = "black",
    background: ColorLike | None = "white",
    device: Device | None = None,
) -> "Image":
    """Draw the edges of a model; return a Pillow image, mode RGBA.

    model : a Mesh, or the path of a model file
    transform : (4, 4), from the model to the world; the identity by default
    camera : `Camera.fit` of the transformed model by default
    size : (width, height) in pixels
    line_width : pixels, positive and at most 1e6
    color : a name, "#rrggbb", or numbers from 0 to 1; "face" draws the outline of each face in its own colour, from a
        cycle of ten, later faces over earlier ones
    background : a colour, or None for transparent
    device : by default the process's own

    Raises `MeshError` for a model without edges, `ArgumentError` that names the argument otherwise.
    """
    return images.image(
        render_array(
            model,
            transform=transform,
            camera=camera,
            size=size,
            line_width=line_width,
            color=color,
            background=background,
            device=device,
        )
    )


def render_array(
    model: Model,
    *,
    transform: MatrixLike | None = None,
    camera: Camera | None = None,
    size: Size = (1024, 1024),
    line_width: float = 1.5,
    color: ColorLike = "black",
    background: ColorLike | None = "white",
    device: Device | None = None,
) -> images.Pixels:
    """Draw as `render` does; return (height, width, 4) uint8, straight alpha, row 0 at the top."""
    mesh = drawable(model)
    width, height = picture_size(size)
    world_from_model = np.eye(4) if transform is None else square_matrix(transform, "transform", 4)
    line_width = number(line_width, "line_width")
    if not 0.0 < line_width <= WIDEST_LINE:
        raise ArgumentError(f"line_width must be positive and at most {WIDEST_LINE:g}, got {line_width:g}")
    edges, colors = colored_edges(mesh, color)
    backdrop = (0.0, 0.0, 0.0, 0.0) if background is None else rgba(background, "background")
    if len(edges) == 0:
        raise MeshError("model must have edges to draw, got only edges from a point to itself")
    if camera is None:
        camera = Camera.fit(world_positions(mesh, world_from_model))
    elif not isinstance(camera, Camera):
        raise ArgumentTypeError(f"camera must be a Camera, got {type(camera).__name__}")
    device = device or default_device()
    require_drawable(mesh, (width, height), device)
    positions, model_from_unit = in_unit_cube(mesh)
    clip_from_unit = camera.clip_from_world(width / height) @ world_from_model @ model_from_unit
    premultiplied = line_pass.draw(
        device,
        positions,
        clip_from_unit / (np.abs(clip_from_unit).max() or 1.0),  # homogeneous: a factor changes nothing
        edges,
        colors,
        size=(width, height),
        line_width=line_width,
        background=backdrop,
    )
    return premultiplied if backdrop[3] == 1.0 else images.straight_alpha(premultiplied)


def drawable(model: Model) -> Mesh:
    """Return the mesh of `model`; raise where there is nothing to draw."""
    if isinstance(model, str | os.PathLike):
        from .formats import load_mesh

        mesh = load_mesh(model)
    elif isinstance(model, Mesh):
        mesh = model
    else:
        raise ArgumentTypeError(f"model must be a Mesh or a path, got {type(model).__name__}")
    if len(mesh.face_edges) == 0:
        raise MeshError(f"model must have edges to draw, got {mesh.n_points} points and {mesh.n_faces} faces")
    return mesh


def picture_size(size: Size) -> tuple[int, int]:
    """Return `size` as two positive integers."""
    try:
        width, height = (int(side) for side in size)
        whole = [width, height] == list(size)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"size must be (width, height), got {size!r}") from None
    if not whole or width < 1 or height < 1:
        raise ArgumentError(f"size must be two positive whole numbers, got {size!r}")
    return width, height


def require_drawable(mesh: Mesh, size: tuple[int, int], device: Device) -> None:
    """Raise `ArgumentError` where the picture or the model is larger than `device` can take."""
    side = device.limits.max_texture_size
    if max(size) > side:
        raise ArgumentError(f"size must be at most {side} x {side} on {device.name!r}, got {size[0]} x {size[1]}")
    most = line_pass.max_points(device)
    if mesh.n_points > most:
        raise ArgumentError(f"model must have at most {most:,} points on {device.name!r}, got {mesh.n_points:,}")


def colored_edges(mesh: Mesh, color: ColorLike) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32]]:
    """Return the edges to draw (m, 2) in their order, and their packed colours (1,) or (m,)."""
    if isinstance(color, str) and color == "face":
        cycle = packed([rgba(name, "color") for name in FACE_CYCLE])
        return mesh.face_edges.astype(np.uint32), cycle[mesh.face_edge_faces % len(cycle)]
    return mesh.edges.astype(np.uint32), packed([rgba(color, "color")])


def in_unit_cube(mesh: Mesh) -> tuple[npt.NDArray[np.float32], Float64Array]:
    """Return the points of `mesh` moved and scaled into [-1, 1]^3, and the (4, 4) matrix that puts them back.

    Single precision would lose the shape of a small model far from the origin, and has no room for very large ones.
    """
    half_size = float((mesh.bounds[1] - mesh.center).max()) or 1.0
    model_from_unit = np.diag([half_size, half_size, half_size, 1.0])
    model_from_unit[:3, 3] = mesh.center
    return ((mesh.positions - mesh.center) / half_size).astype(np.float32), model_from_unit


def world_positions(mesh: Mesh, world_from_model: Float64Array) -> Float64Array:
    """Return the points of `mesh` in the world, divided by w: (n, 3); what has w <= 0 is left out."""
    homogeneous = mesh.positions @ world_from_model[:, :3].T + world_from_model[:, 3]
    in_front = homogeneous[homogeneous[:, 3] > 0.0]
    return np.asarray(in_front[:, :3] / in_front[:, 3:])
