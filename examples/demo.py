"""Demonstration: four pictures, and the throughput of a bulk transform."""

import statistics
import time
from pathlib import Path

import numpy as np

import gpu_xform as gx

SIZE = (1024, 1024)
WIDE = (1024, 640)
N_POINTS = 4_000_000


def draw(folder: Path, device: gx.Device) -> list[Path]:
    """Draw a ball of 92 faces from a model file, in colours per face, a cube, a teapot and a house in perspective."""
    folder.mkdir(exist_ok=True)
    model = folder / "snub_dodecahedron.obj"
    gx.save_mesh(gx.samples.snub_dodecahedron(), model)
    ball = gx.load_mesh(model)
    cube = gx.samples.cube()
    house = gx.samples.house()
    teapot = gx.samples.teapot()
    turned = gx.rotate_y(-25, degrees=True)
    flat = gx.Camera.window((-2.5, 2.5), (-2.5, 2.5))
    from_the_eye = gx.Camera.eye_on_z(8, (-2, 2), (-2, 2))
    pictures = {
        "snub_dodecahedron.png": gx.render(ball, camera=flat, color="face", size=SIZE, line_width=2, device=device),
        "cube.png": gx.render(cube, transform=turned, camera=from_the_eye, size=SIZE, line_width=2, device=device),
        "teapot.png": gx.render(teapot, size=WIDE, line_width=2, hidden="remove", color="#1f3a5f", device=device),
        "house.png": gx.render(house, size=SIZE, line_width=2, color="#1f3a5f", device=device),
    }
    for name, picture in pictures.items():
        picture.save(folder / name)
    return [model, *(folder / name for name in pictures)]


def measure(device: gx.Device) -> float:
    """Return millions of points per second, from array to array, the median of seven runs; check the result."""
    rng = np.random.default_rng(0)
    points = rng.standard_normal((N_POINTS, 3), dtype=np.float32)
    matrix = gx.chain(gx.scale(0.3), gx.rotate_z(90, degrees=True), gx.translate(-0.5, 2, 0))
    result = np.empty_like(points)
    seconds = []
    for _ in range(8):
        start = time.perf_counter()
        gx.transform_points(points, matrix, out=result, device=device)
        seconds.append(time.perf_counter() - start)
    expected = points @ matrix[:3, :3].T + matrix[:3, 3]
    if not np.allclose(result, expected, rtol=0, atol=1e-5):
        raise SystemExit("the transform is wrong on this device; run gpu-xform doctor")
    return N_POINTS / statistics.median(seconds[1:]) / 1e6


def main() -> None:
    """Draw, measure, and print what was written."""
    device = gx.Device()
    for path in draw(Path("demo"), device):
        print(f"wrote {path}")
    rate = measure(device)
    kind = "a CPU" if device.adapter.kind == "CPU" else device.adapter.kind
    size = f"{N_POINTS / 1e6:.0f} million points"
    print(f"{device.name}, {kind}: {size}, array in, array out, at {rate:,.0f} million a second")


if __name__ == "__main__":
    main()
