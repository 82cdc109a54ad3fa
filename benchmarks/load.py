"""Loading OBJ and STL files of a million faces, beside trimesh in the same run.

    python benchmarks/load.py [faces]

Before anything is timed, both readers must have found the same triangles. trimesh runs as fast as it goes (nothing
processed or reordered, no materials) and as it comes.
"""

import sys
import tempfile
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from harness import Contender, Row, medians, table

from gpu_xform import samples
from gpu_xform.formats import load_mesh
from gpu_xform.geometry.mesh import Mesh


def triangles(side: int) -> bytes:
    grid = samples.grid(side)
    return _points("v", grid.positions) + _faces(grid.to_trimesh().faces, "%d")


def quads_with_uv_and_normals(side: int) -> bytes:
    grid = samples.grid(side)
    text = _points("v", grid.positions) + _points("vt", grid.positions[:, :2]) + _points("vn", grid.positions + 1)
    return text + _faces(np.asarray(grid.faces).repeat(3, axis=1), "%d/%d/%d")


def mixed_polygons(side: int) -> bytes:
    """Two triangles, a quad, two triangles, a quad, ..."""
    grid = samples.grid(side)
    quads = np.asarray(grid.faces)
    split = grid.to_trimesh().faces.reshape(-1, 2, 3)[: len(quads)]
    third = len(quads) // 3
    pairs = _faces(split[:third].reshape(-1, 3), "%d").splitlines()
    singles = _faces(quads[third : 2 * third], "%d").splitlines()
    lines = [line for three in zip(pairs[::2], pairs[1::2], singles, strict=True) for line in three]
    return _points("v", grid.positions) + b"\n".join(lines) + b"\n"


def triangles_with_relative_indices(side: int) -> bytes:
    grid = samples.grid(side)
    # Behind all points, for trimesh counts back from the last point of the file and not from the last one before.
    return _points("v", grid.positions) + _faces(grid.to_trimesh().faces - grid.n_points - 1, "%d")


def _points(keyword: str, rows: Any) -> bytes:
    template = keyword.encode() + b" %.9g" * rows.shape[1] + b"\n"
    text: bytes = (template * len(rows)) % tuple(rows.ravel().tolist())
    return text


def _faces(rows: Any, corner: str) -> bytes:
    n_corners = rows.shape[1] // corner.count("%")
    template = b"f" + (b" " + corner.encode()) * n_corners + b"\n"
    text: bytes = (template * len(rows)) % tuple((rows + 1).ravel().tolist())
    return text


def same_triangles(mine: Mesh, other: Any) -> bool:
    """Tell whether both are made of the same triangles, in any order, cut from polygons as fans."""
    direction = np.array([0.577, 1.313, 2.171])

    def keys(points: Any, corners: Any) -> Any:
        rows = np.sort((points @ direction)[corners], axis=1)
        return rows[np.lexsort(rows.T)]

    fans = mine.to_trimesh()
    return np.array_equal(keys(fans.vertices, fans.faces), keys(np.asarray(other.vertices), np.asarray(other.faces)))


def binary_stl(side: int) -> bytes:
    data: bytes = samples.grid(side).to_trimesh().export(file_type="stl")
    return data


def main() -> None:
    n_faces = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    # The most that reading may take of trimesh's time, unprocessed and by default, which for STL merges corners too.
    cases = [
        (triangles, int((n_faces / 2) ** 0.5), 1.0, None),
        (quads_with_uv_and_normals, int(n_faces**0.5), 1.0, None),
        (mixed_polygons, int(n_faces**0.5), 1.0, None),
        (triangles_with_relative_indices, int((n_faces / 2) ** 0.5), 1.0, 1.0),
        (binary_stl, int((n_faces / 2) ** 0.5), 1.5, 1.0),
    ]
    rows = []
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        for make, side, most_of_unprocessed, most_of_default in cases:
            suffix = "stl" if make is binary_stl else "obj"
            path = Path(folder) / f"{make.__name__}.{suffix}"
            path.write_bytes(make(side))
            settings: dict[str, Any] = {"process": False}
            settings |= {"maintain_order": True, "skip_materials": True} if suffix == "obj" else {}
            unprocessed = partial(trimesh.load, path, **settings)
            default = partial(trimesh.load, path)
            mesh = load_mesh(path)
            if not same_triangles(mesh, unprocessed()):
                raise SystemExit(f"{path.name}: the readers disagree")
            what = f"{make.__name__.replace('_', ' ')}, {mesh.n_faces} faces, {path.stat().st_size / 1e6:.0f} MB"
            contenders: dict[str, Contender] = {
                "here": partial(load_mesh, path),
                "unprocessed": unprocessed,
                "default": default,
            }
            seconds = medians(contenders, rounds=5, warm_up=1)
            peers = (("unprocessed", most_of_unprocessed), ("default", most_of_default))
            for (peer, at_most), name in zip(peers, ("unprocessed", "by default"), strict=True):
                rows.append(Row(what, f"trimesh, {name}", seconds["here"], seconds[peer], at_most=at_most))
    print(table(rows))


if __name__ == "__main__":
    main()
