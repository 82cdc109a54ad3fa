"""Legible style: what pictures of many models are drawn in, of which nobody has looked at each."""

from ..geometry.mesh import Mesh
from .layer import Style

PIXELS_PER_FACE = 16  # of meshes whose lines are seen one by one


def legible_style(mesh: Mesh, size: tuple[int, int]) -> Style:
    """Return a style that shows the shape of a mesh in a picture of `size` pixels: of a cube as of a scan.

    Faces are shaded. Sharp edges and the outline lie over them if faces are few for the picture; dense meshes,
    whose noise would have sharp edges everywhere, have no lines. Models without faces are drawn as they always are.
    """
    if mesh.n_faces == 0:
        return {}
    if mesh.n_faces * PIXELS_PER_FACE > size[0] * size[1]:
        return {"fill": "shade", "color": "none"}
    return {"fill": "shade", "edges": ["feature", "silhouette"], "line_width": "auto"}
