"""The lecture's homework: a house rotates about its own axis, and a ball rolls by in front of it without slipping.

The eye is at (0, 0, 100), the picture lies in the xy-plane, and composed matrices alone place everything that moves.
The page with a player needs no extra; the MP4 needs the extra `video`: `pip install '.[video]'`.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt

import gpu_xform as gx

Matrix = npt.NDArray[np.float64]

N_FRAMES = 150
FPS = 25
XLIM, YLIM = (-26.0, 26.0), (-17.0, 13.0)
GROUND = -11.0  # y
BALL = gx.samples.snub_dodecahedron()
BALL_SIZE = 1.8
RADIUS = BALL_SIZE * float(np.linalg.norm(BALL.positions, axis=1).max())
REACH = 25.0  # the ball rolls from x = -25 to x = 25, out of sight at both ends
IN_FRONT = 25.0  # z of the ball; the house stands at z = -10


def world_from_house(frame: float) -> Matrix:
    """Return where the house is: it turns once in all frames, about the y-axis of its own frame."""
    return gx.chain(
        gx.scale(8, 10, 8),
        gx.rotate_y(360 * frame / N_FRAMES, degrees=True),
        gx.translate(0, GROUND + 10, -10),
    )


def world_from_ball(frame: float) -> Matrix:
    """Return where the ball is: the way that it has rolled is its radius times the angle that it has turned."""
    rolled = 2 * REACH * frame / N_FRAMES
    return gx.chain(
        gx.scale(BALL_SIZE),
        gx.rotate_z(-rolled / RADIUS),  # to the right is clockwise, as seen from the eye
        gx.translate(rolled - REACH, GROUND + RADIUS, IN_FRONT),
    )


def poses(frame: float) -> dict[str, Matrix]:
    """Return the matrix of each node that moves."""
    return {"house": world_from_house(frame), "ball": world_from_ball(frame)}


def stage() -> gx.Scene:
    """Return the scene as it begins: house, ball, and the ground beneath them."""
    scene = gx.Scene()
    ground = gx.chain(gx.scale(60), gx.rotate_x(-90, degrees=True), gx.translate(0, GROUND, 0))
    scene.add(gx.samples.grid(24), name="ground", transform=ground, color="#c8c8c8", line_width=1)
    scene.add(gx.samples.house(), name="house", color="#1f3a5f", line_width=2)
    scene.add(BALL, name="ball", color="face", line_width=1.5)
    return scene.posed(poses(0))


def main() -> None:
    """Draw all frames once for each file; what needs an extra that is not installed is left out."""
    folder = Path("demo")
    folder.mkdir(exist_ok=True)
    movie = gx.animate(
        stage(), poses, n_frames=N_FRAMES, fps=FPS, size=(832, 480), camera=gx.Camera.eye_on_z(100, XLIM, YLIM)
    )
    for name in ("house_and_ball.html", "house_and_ball.mp4"):
        try:
            movie.save(folder / name)
        except gx.MissingExtraError as error:
            print(f"left out {folder / name}: {error}")
        else:
            print(f"wrote {folder / name}")


if __name__ == "__main__":
    main()
