"""Pages that draw models live: their bytes beside pyvista's, and their time per frame beside three.js'.

    python benchmarks/web_pages.py [--three FOLDER] [--frames N]

FOLDER is `build` of the npm package `three`. Both draw the same lines in one page in headless Chromium on SwiftShader,
in turn; a frame ends when the device has drawn it. Without FOLDER, sizes alone are measured; pyvista's if it is
installed, with its extra `jupyter`.
"""

import argparse
import gzip
import itertools
import statistics
import sys
import tempfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

import gpu_xform as gx
from gpu_xform.web.short_program import make_program

sys.path.insert(0, str(Path(__file__).parents[1]))

SIZE = (800, 600)
GRID_STEPS = (1 << 19) - 1

THREE = """
const [core, module, antialias, size, frames, done] = arguments;
const url = text => URL.createObjectURL(new Blob([text], {type: "text/javascript"}));
(async () => {
  const page = await window.gpuXform, edges = EDGES, points = POINTS;
  const three = await import(url(module.replaceAll("./three.core.js", url(core))));
  const renderer = new three.WebGLRenderer({antialias}), scene = new three.Scene();
  renderer.setSize(...size, false);
  scene.background = new three.Color(0xffffff);
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(Float32Array.from(points), 3));
  geometry.setIndex(new three.BufferAttribute(edges, 1));
  const lines = new three.LineSegments(geometry, new three.LineBasicMaterial({color: 0}));
  scene.add(lines);
  const camera = new three.PerspectiveCamera(30, size[0] / size[1], 0.1, 100);
  camera.position.set(0, 0, 4.2);
  const gl = renderer.getContext(), pixel = new Uint8Array(4);
  const drawThree = async angle => {
    lines.rotation.y = angle;
    renderer.render(scene, camera);
    gl.readPixels(size[0] >> 1, size[1] >> 1, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  };
  const canvas = document.querySelector("canvas");
  const drawOurs = async () => {
    page.press("ArrowLeft");
    page.drawNow();
    await page.renderer.whenDone();
  };
  const times = {ours: [], three: []};
  for (let k = 0; k < frames + 3; k++) {
    for (const [name, draw] of [["ours", drawOurs], ["three", () => drawThree(0.26 * k)]]) {
      const start = performance.now();
      await draw();
      if (k >= 3) times[name].push(performance.now() - start);
    }
  }
  renderer.render(scene, camera);
  const shot = renderer.domElement.toDataURL();
  const image = new Image();
  image.src = shot;
  await image.decode();
  const flat = new OffscreenCanvas(...size).getContext("2d");
  flat.drawImage(image, 0, 0);
  const dark = flat.getImageData(0, 0, ...size).data.filter((value, i) => i % 4 === 0 && value < 128).length;
  return {times, edges: edges.length / 2, dark, renderer: page.renderer.name};
})().then(done, error => done({error: String(error.stack ?? error)}));
"""


def split_page(path: Path) -> tuple[int, int]:
    """Return the bytes of a page without its scene, and of the scene."""
    text = path.read_text("utf-8")
    scene = text.split('id="scene">')[1].split("<")[0]
    return len(text.encode()) - len(scene), len(scene)


def count_baseline_bytes(mesh: gx.Mesh) -> int:
    """Return the bytes of the mesh's positions, on the grid of pages, and of its indices, each gzipped."""
    center = mesh.bounds.mean(axis=0)
    grid = np.rint((mesh.positions - center) / np.abs(mesh.positions - center).max() * GRID_STEPS).astype("<i4")
    indices = mesh.indices.astype("<u2" if mesh.n_points < 1 << 16 else "<u4")
    return len(zlib.compress(grid.tobytes(), 9)) + len(zlib.compress(indices.tobytes(), 9))


def export_with_pyvista(mesh: gx.Mesh, path: Path) -> int | None:
    """Return the bytes of pyvista's page, gzipped; None if it is not installed."""
    try:
        import pyvista
    except ImportError:
        return None
    faces = np.asarray(mesh.faces)
    plotter = pyvista.Plotter(off_screen=True)
    cells = np.column_stack([np.full(len(faces), faces.shape[1]), faces]).ravel()
    plotter.add_mesh(pyvista.PolyData(mesh.positions, cells), style="wireframe", color="black")
    plotter.export_html(str(path))
    return len(gzip.compress(path.read_bytes(), 9))


def measure_sizes(folder: Path) -> None:
    """Print what pages and the meshes in them take."""
    models = {
        "icosphere 3": gx.samples.icosphere(3),
        "icosphere 6": gx.samples.icosphere(6),
        "torus 200 x 100": gx.samples.torus(200, 100),
        "teapot": gx.samples.teapot(),
    }
    head = ("page", "gzipped", "rest", "gzipped", "scene", "ratio", "gzipped", "pyvista")
    print(f"{'model':16}", *(f"{word:>9}" for word in head))
    for name, mesh in models.items():
        path = folder / "page.html"
        gx.save_page(mesh, path, size=SIZE)
        whole = path.read_bytes()
        rest, scene = split_page(path)
        packed = len(gzip.compress(whole, 9))
        before, after = whole.split(b'id="scene">')
        rest_packed = len(gzip.compress(before + after.split(b"<", 1)[1], 9))
        baseline = count_baseline_bytes(mesh)
        other = export_with_pyvista(mesh, folder / "pyvista.html")
        ratios = [scene / baseline, (packed - rest_packed) / baseline]
        sizes = [len(whole), packed, rest, rest_packed, scene]
        print(f"{name:16}", *(f"{n:9,}" for n in sizes), *(f"{ratio:9.2f}" for ratio in ratios), f"{other or 0:9,}")


def measure_frames(folder: Path, three: Path, n_frames: int) -> None:
    """Print the medians of both, and their ratio."""
    from tests.support.browser import Browser

    path = folder / "ball.html"
    with Browser(webgpu=True) as browser:
        sources = [(three / f"three.{part}.js").read_text("utf-8") for part in ("core", "module")]
        for level, is_smooth in itertools.product((4, 5), (True, False)):
            gx.save_page(gx.samples.icosphere(level), path, size=SIZE, line_width=1.0, antialias=is_smooth)
            browser.open(path, SIZE)
            browser.driver.set_script_timeout(300)
            browser.wait_for("window.livePage && livePage.isReady", 60)
            given = (*sources, is_smooth, list(SIZE), n_frames)
            script = THREE
            for word, name in (("EDGES", "edges"), ("POINTS", "points")):
                script = script.replace(word, make_program().names.rename_script(f"page.scene.layers[0].mesh.{name}"))
            found: dict[str, Any] = browser.driver.execute_async_script(script, *given)
            if "error" in found:
                raise RuntimeError(found["error"])
            if found["renderer"] != "WebGPU" or found["dark"] < SIZE[0] * SIZE[1] // 50:
                raise RuntimeError(f"one of the two has drawn nothing: {found}")
            ours, theirs = (statistics.median(found["times"][name]) for name in ("ours", "three"))
            look = "smooth" if is_smooth else "jagged"
            print(
                f"{found['edges']:,} {look} lines: {ours:.1f} ms, three.js {theirs:.1f} ms, ratio {ours / theirs:.2f}"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--three", type=Path)
    parser.add_argument("--frames", type=int, default=20)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        measure_sizes(Path(folder))
        if options.three:
            measure_frames(Path(folder), options.three, options.frames)


if __name__ == "__main__":
    main()
