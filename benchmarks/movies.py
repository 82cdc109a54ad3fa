"""Two movies, made by this library and by its peers: a sphere as MP4, and a ball of 92 faces as GIF."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import gpu_xform as gx
from gpu_xform.imaging.colors import COLOR_CYCLE

SPHERE_SIZE, SPHERE_FRAMES = (1280, 720), 150
BALL_SIZE, BALL_FRAMES = (640, 480), 100
FEW_FRAMES = 15  # of a movie that would take minutes
FPS = 20
LINE_WIDTH = 1.5
DPI = 100
EYE, TARGET, UP, FOV_Y = (0.9, 0.8, 3.5), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0
CAMERA = gx.Camera.look_at(EYE, TARGET, UP, fov_y=FOV_Y)
LIMITS = (-5.0, 5.0)  # as in the lecture


class Maker(NamedTuple):
    """What writes a movie of a mesh to a path that ends in `suffix`."""

    suffix: str
    make: Callable[[gx.Mesh, Path], object]


def turn(k: int, n_frames: int) -> npt.NDArray[np.float64]:
    """Return the matrix of frame k."""
    return gx.rotate((1, 2, 3), 2 * np.pi * k / n_frames)


def sphere_here(mesh: gx.Mesh, path: Path) -> None:
    """Write the MP4 with this library."""
    turns = [turn(k, SPHERE_FRAMES) for k in range(SPHERE_FRAMES)]
    gx.animate(mesh, turns, path, fps=FPS, size=SPHERE_SIZE, camera=CAMERA, line_width=LINE_WIDTH)


def ball_here(mesh: gx.Mesh, path: Path) -> None:
    """Write the GIF with this library."""
    turns = [turn(k, BALL_FRAMES) for k in range(BALL_FRAMES)]
    window = gx.Camera.window(LIMITS, LIMITS)
    gx.animate(mesh, turns, path, fps=FPS, size=BALL_SIZE, camera=window, line_width=LINE_WIDTH, color="face")


def sphere_pyvista(mesh: gx.Mesh, path: Path) -> None:
    """Write the MP4 with pyvista: an actor that is turned, and a frame after each turn."""
    import pyvista

    cells = np.insert(mesh.edges, 0, 2, axis=1)
    lines = pyvista.PolyData(mesh.positions.astype(np.float32), lines=cells.ravel())
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(SPHERE_SIZE))
    actor = plotter.add_mesh(lines, color="black", line_width=LINE_WIDTH, lighting=False)
    plotter.background_color = "white"
    plotter.enable_anti_aliasing("msaa")
    plotter.camera_position = [EYE, TARGET, UP]
    plotter.camera.view_angle = FOV_Y
    plotter.open_movie(path, framerate=FPS)
    for k in range(SPHERE_FRAMES):
        actor.user_matrix = turn(k, SPHERE_FRAMES)
        plotter.write_frame()
    plotter.close()


def sphere_matplotlib(mesh: gx.Mesh, path: Path) -> None:
    """Write the first frames of the MP4 with matplotlib, in axes that project as CAMERA does."""
    import imageio_ffmpeg
    import matplotlib as mpl
    from matplotlib.animation import FuncAnimation
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    mpl.rcParams["animation.ffmpeg_path"] = imageio_ffmpeg.get_ffmpeg_exe()
    figure = _figure(SPHERE_SIZE)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d")
    axes.set_axis_off()
    lines: Any = Line3DCollection(mesh.positions[mesh.edges], colors="black", linewidths=LINE_WIDTH * 72 / DPI)
    axes.add_collection3d(lines)
    axes.get_proj = lambda: CAMERA.clip_from_world(SPHERE_SIZE[0] / SPHERE_SIZE[1])
    axes.apply_aspect = lambda _=None: None  # which would make them square
    axes.viewLim.intervalx = axes.viewLim.intervaly = (-1.0, 1.0)

    def draw(k: int) -> list[Any]:
        lines.set_segments((mesh.positions @ turn(k, SPHERE_FRAMES)[:3, :3].T)[mesh.edges])
        return [lines]

    FuncAnimation(figure, draw, frames=FEW_FRAMES).save(path, writer="ffmpeg", fps=FPS, dpi=DPI)


def ball_matplotlib(mesh: gx.Mesh, path: Path) -> None:
    """Write the GIF with matplotlib as the lecture does: a line for each face, given new ends in each frame."""
    from matplotlib.animation import FuncAnimation

    outlines = [mesh.positions[np.append(face, face[0])].T for face in mesh.faces]
    figure = _figure(BALL_SIZE)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    widened = np.array(LIMITS) * BALL_SIZE[0] / BALL_SIZE[1]
    axes.set_xlim(*widened)
    axes.set_ylim(*LIMITS)
    lines = [
        axes.plot([], [], color=COLOR_CYCLE[i % len(COLOR_CYCLE)], linewidth=LINE_WIDTH * 72 / DPI)[0]
        for i in range(len(outlines))
    ]

    def draw(k: int) -> list[Any]:
        rotation = turn(k, BALL_FRAMES)[:3, :3]
        for line, outline in zip(lines, outlines, strict=True):
            x, y, _ = rotation @ outline
            line.set_data(x, y)
        return list(lines)

    FuncAnimation(figure, draw, frames=BALL_FRAMES).save(path, writer="pillow", fps=FPS, dpi=DPI)


def _figure(size: tuple[int, int]) -> Any:
    from matplotlib import pyplot as plt

    plt.switch_backend("agg")
    return plt.figure(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI)


SPHERE_MAKERS: Mapping[str, Maker] = {
    "ours": Maker(".mp4", sphere_here),
    "pyvista open_movie": Maker(".mp4", sphere_pyvista),
    "matplotlib FuncAnimation": Maker(".mp4", sphere_matplotlib),
}
BALL_MAKERS: Mapping[str, Maker] = {
    "ours": Maker(".gif", ball_here),
    "matplotlib FuncAnimation": Maker(".gif", ball_matplotlib),
}
