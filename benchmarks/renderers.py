"""One wireframe, drawn by this library and by its peers: black on white, with one camera.

Each function takes a mesh, and sets up a scene that does not change between frames.
"""

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from pictures import Pixels

import gpu_xform as gx

SIDE = 1024
EYE, TARGET, UP, FOV_Y = (0.9, 0.8, 3.5), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0
LINE_WIDTH = 1.5
COLORMAP = "viridis"
CAMERA = gx.Camera.look_at(EYE, TARGET, UP, fov_y=FOV_Y)


class Scene(NamedTuple):
    """A function that draws a frame and reads it back, (SIDE, SIDE, 3 or 4) uint8; the name of its device."""

    frame: Callable[[], Pixels]
    drawn_on: str


def here(mesh: gx.Mesh, **style: Any) -> Scene:
    """Return the scene in this library: a mesh that is drawn again."""
    from gpu_xform.gpu.device import default_gpu_device

    draw = partial(gx.render_array, mesh, camera=CAMERA, size=(SIDE, SIDE), line_width=LINE_WIDTH, **style)
    return Scene(draw, default_gpu_device().name)


def here_by_height(mesh: gx.Mesh) -> Scene:
    """Return the scene in this library, in colours that go by height."""
    return here(mesh, scalars=mesh.positions[:, 2], cmap=COLORMAP)


def moderngl_lines(mesh: gx.Mesh) -> Scene:
    """Return GL_LINES by index, one pixel wide, not anti-aliased."""
    import moderngl

    egl: Any = "egl"  # annotated as a dict over there
    context: Any = moderngl.create_context(standalone=True, backend=egl)
    clip_from_world = CAMERA.clip_from_world(1.0)
    clip_from_world[2] = 2.0 * clip_from_world[2] - clip_from_world[3]  # OpenGL's depth runs from -1
    program = context.program(
        vertex_shader="""#version 330
            uniform mat4 clip_from_world;
            in vec3 position;
            void main() { gl_Position = clip_from_world * vec4(position, 1.0); }""",
        fragment_shader="""#version 330
            out vec4 color;
            void main() { color = vec4(0.0, 0.0, 0.0, 1.0); }""",
    )
    program["clip_from_world"].write(clip_from_world.T.astype(np.float32).tobytes())
    vertices = context.buffer(mesh.positions.astype(np.float32).tobytes())
    indices = context.buffer(mesh.edges.astype(np.uint32).tobytes())
    lines = context.vertex_array(program, [(vertices, "3f", "position")], index_buffer=indices)
    target = context.simple_framebuffer((SIDE, SIDE), components=4)
    target.use()

    def frame() -> Pixels:
        target.clear(1.0, 1.0, 1.0, 1.0)
        lines.render(moderngl.LINES)
        return np.frombuffer(target.read(components=4), np.uint8).reshape(SIDE, SIDE, 4)[::-1]

    return Scene(frame, context.info["GL_RENDERER"])


def pygfx_segments(mesh: gx.Mesh, ppaa: str = "default", **material: Any) -> Scene:
    """Return line segments, anti-aliased when all is drawn (`ppaa`), as each is drawn (`aa`), or both."""
    import pygfx

    ends = mesh.positions[mesh.edges].reshape(-1, 3).astype(np.float32)
    material = {"thickness": LINE_WIDTH, "color": "black", **material}
    line = pygfx.Line(pygfx.Geometry(positions=ends), pygfx.LineSegmentMaterial(**material))
    return _pygfx(line, ppaa)


def pygfx_wireframe(mesh: gx.Mesh, ppaa: str = "default") -> Scene:
    """Return the wireframe of a mesh, anti-aliased when all is drawn."""
    import pygfx

    indices = np.asarray(mesh.faces).astype(np.int32)
    geometry = pygfx.Geometry(positions=mesh.positions.astype(np.float32), indices=indices)
    material = pygfx.MeshBasicMaterial(color="black", wireframe=True, wireframe_thickness=LINE_WIDTH)
    return _pygfx(pygfx.Mesh(geometry, material), ppaa)


def _pygfx(shown: Any, ppaa: str) -> Scene:
    import pygfx
    from rendercanvas.offscreen import RenderCanvas

    canvas = RenderCanvas(size=(SIDE, SIDE), pixel_ratio=1)
    renderer = pygfx.WgpuRenderer(canvas, pixel_ratio=1, ppaa=ppaa)  # by default four times as many pixels
    scene = pygfx.Scene()
    scene.add(pygfx.Background.from_color("white"), shown)
    camera = pygfx.PerspectiveCamera(FOV_Y, 1.0, depth_range=(0.01, 100.0))
    camera.local.position = EYE
    camera.look_at(TARGET)
    canvas.request_draw(lambda: renderer.render(scene, camera))
    return Scene(lambda: np.asarray(canvas.draw()), renderer.device.adapter.info["device"])


def pyvista_lines(mesh: gx.Mesh, *, by_height: bool = False) -> Scene:
    """Return a PolyData of lines, multisampled, black or in colours that go by height."""
    import pyvista

    cells = np.insert(mesh.edges, 0, 2, axis=1)
    lines = pyvista.PolyData(mesh.positions.astype(np.float32), lines=cells.ravel())
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=[SIDE, SIDE])
    colors: dict[str, Any] = {"color": "black"}
    if by_height:
        colors = {"scalars": mesh.positions[:, 2], "cmap": COLORMAP, "show_scalar_bar": False}
    plotter.add_mesh(lines, line_width=LINE_WIDTH, lighting=False, **colors)
    plotter.background_color = "white"
    plotter.enable_anti_aliasing("msaa")
    plotter.camera_position = [EYE, TARGET, UP]
    plotter.camera.view_angle = FOV_Y
    plotter.show(auto_close=False)

    def frame() -> Pixels:
        plotter.render()  # `image` is of the last frame, and so is `screenshot`
        return np.asarray(plotter.image)

    found = re.search(r"OpenGL renderer string: *(.*)", plotter.render_window.ReportCapabilities())
    return Scene(frame, found[1] if found else "unknown")


def f3d_edges(mesh: gx.Mesh) -> Scene:
    """Return a white mesh with black edges, which hides those behind it."""
    import f3d

    f3d.Log.set_verbose_level(f3d.Log.VerboseLevel.QUIET)
    engine = f3d.Engine.create(True)
    engine.options.update(
        {
            "model.color.rgb": (1.0, 1.0, 1.0),
            "model.unlit": True,
            "render.background.color": (1.0, 1.0, 1.0),
            "render.line_width": LINE_WIDTH,
            "render.show_edges": True,
        }
    )
    faces = np.asarray(mesh.faces)
    engine.scene.add(
        f3d.Mesh(mesh.positions.ravel().tolist(), face_sides=[3] * len(faces), face_indices=faces.ravel().tolist())
    )
    window = engine.window
    window.size = SIDE, SIDE
    window.camera.position, window.camera.focal_point, window.camera.view_up = EYE, TARGET, UP
    window.camera.view_angle = FOV_Y

    def frame() -> Pixels:
        image = engine.window.render_to_image()
        return np.frombuffer(image.content, np.uint8).reshape(SIDE, SIDE, image.channel_count)[::-1]

    return Scene(frame, f"a window of type {engine.window.type.name}")


def matplotlib_lines(mesh: gx.Mesh) -> Scene:
    """Return a Line3DCollection in axes that fill the figure and project as CAMERA does."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    dpi = 100
    figure = Figure(figsize=(SIDE / dpi, SIDE / dpi), dpi=dpi)
    canvas: Any = FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d")
    axes.set_axis_off()
    axes.add_collection3d(
        Line3DCollection(mesh.positions[mesh.edges], colors="black", linewidths=LINE_WIDTH * 72 / dpi)
    )
    axes.get_proj = lambda: CAMERA.clip_from_world(1.0)
    axes.viewLim.intervalx = axes.viewLim.intervaly = (-1.0, 1.0)

    def frame() -> Pixels:
        canvas.draw()
        return np.array(canvas.buffer_rgba())

    return Scene(frame, "the CPU")


def skia_lines(mesh: gx.Mesh) -> Scene:
    """Return lines between points that NumPy has projected, once."""
    import skia

    clip_from_world = CAMERA.clip_from_world(1.0)
    projected = mesh.positions @ clip_from_world[:, :3].T + clip_from_world[:, 3]
    pixels = (projected[:, :2] / projected[:, 3:] * (0.5, -0.5) + 0.5) * SIDE
    ends = [skia.Point(x, y) for x, y in pixels[mesh.edges].reshape(-1, 2).tolist()]
    target = np.empty((SIDE, SIDE, 4), np.uint8)
    canvas = skia.Surface(target).getCanvas()
    paint = skia.Paint(AntiAlias=True, StrokeWidth=LINE_WIDTH, Color=skia.ColorBLACK)

    def frame() -> Pixels:
        canvas.clear(skia.ColorWHITE)
        canvas.drawPoints(skia.Canvas.kLines_PointMode, ends, paint)
        return target.copy()

    return Scene(frame, "the CPU")


RENDERERS: Mapping[str, Callable[[gx.Mesh], Scene]] = {
    "ours": here,
    "ours, aliased": partial(here, antialias=False),
    "ours, hidden lines removed": partial(here, hidden="remove"),
    "ours, aliased, hidden lines removed": partial(here, antialias=False, hidden="remove"),
    "ours, by render passes": partial(here, rasterizer="render"),
    "ours, by render passes, hidden lines removed": partial(here, rasterizer="render", hidden="remove"),
    "ours, by height": here_by_height,
    "moderngl GL_LINES": moderngl_lines,
    "pygfx line segments": pygfx_segments,
    "pygfx line segments, aa=True, ppaa='none'": partial(pygfx_segments, ppaa="none", aa=True, alpha_mode="blend"),
    "pygfx mesh wireframe": pygfx_wireframe,
    "pygfx mesh wireframe, ppaa='fxaa'": partial(pygfx_wireframe, ppaa="fxaa"),
    "pyvista lines, MSAA": pyvista_lines,
    "pyvista lines by height, MSAA": partial(pyvista_lines, by_height=True),
    "f3d mesh with edges": f3d_edges,
    "matplotlib Line3DCollection": matplotlib_lines,
    "skia, projected lines": skia_lines,
}
