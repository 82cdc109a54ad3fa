"""A silk scarf falls over a ball: points joined by springs, drawn with hidden lines removed.

It writes demo/cloth_over_ball.png, the last frame, and demo/cloth_over_ball.gif. On a device other than lavapipe the
folds may come out differently: how a falling cloth buckles depends on the last bit of its positions.
"""

from pathlib import Path

import gpu_xform as gx

N = 56  # quads per side
FPS = 20
DURATION_S = 1.3
CENTER, RADIUS = (0.04, -0.25, -0.03), 0.24  # of the ball, in metres; it is not below the scarf's centre
GAP = 0.006  # between ball and scarf, so that no line of the ball shows
CAMERA = {"direction": (-0.6, -0.55, -1)}


def make_scarf(n: int = N) -> gx.Springs:
    """Return a scarf of 1 m x 1 m and 60 g, which lies flat in the air."""
    mesh = gx.samples.cloth(n, n).transformed(gx.rotate_y(25, degrees=True))
    return gx.Springs(mesh, mass=0.06, stretch=40, shear=4, bend=0.1, damping=2e-4)


def drop(scarf: gx.Springs, duration_s: float = DURATION_S) -> gx.Trajectory:
    """Let the scarf fall over the ball."""
    ball = gx.Sphere(CENTER, RADIUS, friction=0.3, gap=GAP)
    return scarf.simulate(duration_s, fps=FPS, drag=1.0, obstacles=ball)


def stage(scarf: gx.Mesh) -> gx.Scene:
    """Return the scarf, and the outline of the ball where the scarf doesn't hide it."""
    ball = gx.samples.icosphere(4).transformed(gx.chain(gx.scale(RADIUS), gx.translate(*CENTER)))
    scene = gx.Scene()
    scene.add(ball, name="ball", hidden="remove", edges="silhouette", color="#9aa0a6", line_width=1)
    scene.add(scarf, name="scarf", hidden="remove", color="#1f3a5f", line_width=0.8)
    return scene


def main() -> None:
    """Simulate, draw, and print what was written."""
    folder = Path("demo")
    folder.mkdir(exist_ok=True)
    meshes = drop(make_scarf()).meshes()
    picture, movie = folder / "cloth_over_ball.png", folder / "cloth_over_ball.gif"
    gx.render(stage(meshes[-1]), size=(480, 440), camera=CAMERA).convert("RGB").quantize(16).save(
        picture, optimize=True
    )
    print(f"wrote {picture}")
    frames = [stage(mesh) for mesh in meshes]
    gx.animate(frames[0], frames, movie, fps=FPS, size=(480, 400), camera=CAMERA)
    print(f"wrote {movie}")


if __name__ == "__main__":
    main()
