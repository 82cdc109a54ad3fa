"""Bulk transforms beside their peers: each output is checked before its time counts, ratios come from one run.

Run with `python benchmarks/transform.py [millions of points]`; the peers come with `pip install 'gpu_xform[bench]'`.
"""

import sys
from typing import Any

import numpy as np
import numpy.typing as npt
from harness import Contender, Row, medians, table

import gpu_xform as gx

Points = npt.NDArray[Any]


def numpy_idioms(points: Points, matrix: npt.NDArray[np.float64], out: Points) -> dict[str, Contender]:
    """Return the three ways that people write an affine transform of (n, 3) in NumPy."""
    linear = np.ascontiguousarray(matrix[:3, :3].T.astype(points.dtype))
    offset = matrix[:3, 3].astype(points.dtype)

    def operators() -> Points:
        return np.asarray(points @ linear + offset)

    def in_place() -> Points:
        np.matmul(points, linear, out=out)
        np.add(out, offset, out=out)
        return out

    def einsum() -> Points:
        result = np.einsum("ni,ij->nj", points, linear)
        result += offset
        return np.asarray(result)

    return {"NumPy P @ R + t": operators, "NumPy with out=": in_place, "NumPy einsum": einsum}


def peers(points: Points, matrix: npt.NDArray[np.float64], out: Points) -> dict[str, Contender]:
    """Return the same transform by other libraries, each in the fastest way that its documentation offers."""
    import pylinalg
    import pyvista
    import torch
    import trimesh

    single = matrix.astype(points.dtype)
    cloud = pyvista.PolyData(points)
    linear, offset = torch.from_numpy(single[:3, :3].T.copy()), torch.from_numpy(single[:3, 3].copy())
    torch_points, torch_out = torch.from_numpy(points), torch.from_numpy(out)
    return {
        "trimesh transform_points": lambda: trimesh.transform_points(points, matrix),
        "pyvista transform": lambda: cloud.transform(matrix, inplace=False).points,
        "pylinalg vec_transform": lambda: pylinalg.vec_transform(points, single),
        "torch addmm(out=)": lambda: torch.addmm(offset, torch_points, linear, out=torch_out).numpy(),
    }


def scipy_rotation(points: Points, rotation: npt.NDArray[np.float64]) -> Contender:
    """Return SciPy's own way to rotate points."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(rotation[:3, :3])
    return lambda: turn.apply(points)


def checked(contenders: dict[str, Contender], expected: Points, tolerance: float) -> dict[str, Contender]:
    """Return the contenders; stop where one computes something else."""
    for name, run in contenders.items():
        worst = float(np.abs(np.asarray(run()) - expected).max())
        if not worst <= tolerance:
            raise SystemExit(f"{name} is off by {worst}: not compared")
    return contenders


def end_to_end(n_points: int, dtype: npt.DTypeLike) -> list[Row]:
    """Array in, array out, into a warm `out`."""
    rng = np.random.default_rng(1)
    points = rng.standard_normal((n_points, 3)).astype(dtype)
    matrix = gx.chain(gx.scale(0.3, 0.5, 2), gx.rotate((1, 2, 3), 0.7), gx.translate(-0.5, 2, 1))
    rotation = gx.rotate((1, 2, 3), 0.7)
    ours, theirs = np.empty_like(points), np.empty_like(points)
    expected = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    tolerance = 1e-5 if points.dtype == np.float32 else 1e-13
    idioms = numpy_idioms(points, matrix, theirs)
    contenders = {"ours": lambda: gx.transform_points(points, matrix, out=ours)} | idioms
    if points.dtype == np.float32:
        contenders |= peers(points, matrix, theirs)
    contenders = checked(contenders, expected, tolerance)
    if points.dtype == np.float32:
        contenders["ours, a rotation"] = lambda: gx.transform_points(points, rotation, out=ours)
        contenders["SciPy Rotation.apply"] = scipy_rotation(points, rotation)
    seconds = medians(contenders)
    what = f"end to end, {points.dtype}, {n_points / 1e6:g} M"
    best = min(idioms, key=seconds.__getitem__)
    rows = [Row(what, f"best of NumPy: {best}", seconds["ours"], seconds[best], 0.75 if dtype is np.float32 else 1.2)]
    if points.dtype == np.float32:
        asked = {"trimesh transform_points": 0.35, "pyvista transform": 0.35, "pylinalg vec_transform": 0.45}
        asked["torch addmm(out=)"] = 1.0
        rows += [Row(what, name, seconds["ours"], seconds[name], limit) for name, limit in asked.items()]
        rows.append(
            Row(what, "SciPy Rotation.apply", seconds["ours, a rotation"], seconds["SciPy Rotation.apply"], 1.0)
        )
    return rows


def main() -> None:
    """Print the table."""
    millions = float(sys.argv[1]) if len(sys.argv) > 1 else 8.0
    n_points = int(millions * 1e6)
    rows = end_to_end(n_points, np.float32)
    rows += end_to_end(n_points // 2, np.float64)
    device = gx.Device()
    print(f"{device.name}, {device.adapter.driver}; NumPy {np.__version__}\n")
    print(table(rows))


if __name__ == "__main__":
    main()
