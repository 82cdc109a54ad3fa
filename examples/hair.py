"""10,000 strands of hair on a head that shakes: 400 of them are simulated, the others lie between them.

It writes demo/hair.png and demo/hair.gif.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt

import gpu_xform as gx

N_GUIDES, N_STRANDS, N_POINTS = 400, 10_000, 16
RADIUS, LENGTH = 0.1, 0.22  # of the head and of the hair, in metres
POINT_MASS = 1e-5  # kg
STRAIN = 0.03  # of a strand at its root, under its own weight
FPS = 20
DURATION_S = 2.0
PERIOD_S = 1.4  # of the head
ROOT_COLOR, TIP_COLOR = (0.16, 0.08, 0.04), (0.72, 0.47, 0.24)
CAMERA = gx.Camera.look_at((0.3, 0.15, 1.1), (0, -0.07, 0), fov_y=30)  # of the picture; the movie needs more room
DIRECTION = {"direction": (-0.3, -0.22, -1.1)}


def world_from_head(seconds: float) -> npt.NDArray[np.float64]:
    """Return where the head is: it starts to shake half a second after the hair has begun to fall."""
    started = max(0.0, seconds - 0.5)
    return gx.rotate_y(28 * min(1.0, 2 * started) * np.sin(2 * np.pi * started / PERIOD_S), degrees=True)


def swing(n_guides: int = N_GUIDES, duration_s: float = DURATION_S) -> tuple[gx.Strands, gx.Trajectory]:
    """Return the guides as they are at first, standing up, and their motion."""
    hair = gx.samples.hair(n_guides, N_POINTS, radius=RADIUS, length=LENGTH, curls=1.5, curl_radius=0.006)
    stretch = N_POINTS * POINT_MASS * 9.81 / (STRAIN * LENGTH / (N_POINTS - 1))
    springs = hair.springs(stretch, bend=0.03 * stretch, core=0.1 * stretch)
    mass = POINT_MASS * n_guides * N_POINTS
    guides = gx.Springs(hair.mesh, **springs, mass=mass, damping=3e-5, pinned=hair.roots)
    head = gx.Sphere((0, 0, 0), RADIUS, friction=0.2, gap=0.002, transform=world_from_head)
    return hair, guides.simulate(duration_s, FPS, drag_rate=1.5, move_pins=world_from_head, obstacles=head)


def color(n_strands: int) -> npt.NDArray[np.float64]:
    """Return a colour per point, lighter towards the tips and different for each strand."""
    along = np.linspace(0, 1, N_POINTS)[np.newaxis, :, np.newaxis]
    light = np.random.default_rng(0).uniform(0.6, 1.2, (n_strands, 1, 1))
    colors = light * ((1 - along) * ROOT_COLOR + along * TIP_COLOR)
    return np.clip(colors, 0, 1).reshape(-1, 3)


def main() -> None:
    """Simulate, draw, and print what was written."""
    folder = Path("demo")
    folder.mkdir(exist_ok=True)
    hair, path = swing()
    coat = gx.ChildStrands(hair, N_STRANDS - N_GUIDES, clump=0.5)
    head = gx.samples.icosphere(4).transformed(gx.scale(0.98 * RADIUS))

    def stage(frame: int) -> gx.Scene:
        scene = gx.Scene()
        scene.add(head, name="head", edges="silhouette", hidden="remove", fill="#f3e3d3", color="#a08060")
        for name, strands in (("children", coat.meshes(path)[frame]), ("guides", path.meshes()[frame])):
            colors = color(strands.n_points // N_POINTS)
            scene.add(strands, name=name, vertex_colors=colors, line_width=0.8, hidden="remove")
        return scene

    picture, movie = folder / "hair.png", folder / "hair.gif"
    gx.render(stage(round(1.3 * FPS)), camera=CAMERA, size=(480, 480)).save(picture)
    print(f"wrote {picture}")
    gx.animate(stage(0), stage, movie, n_frames=len(path), fps=FPS, camera=DIRECTION, size=(400, 400))
    print(f"wrote {movie}")


if __name__ == "__main__":
    main()
