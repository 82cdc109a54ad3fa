"""Smooth surfaces as meshes, beside geomdl, VTK and OpenSubdiv in the same run.

    python benchmarks/surfaces.py

Before anything is timed, the points of each library must be ours. geomdl evaluates the teapot's patches one by one, in
Python. VTK is asked as pyvista asks it, with normals, and by itself, for points and triangles alone. OpenSubdiv is
called through pyOpenSubdiv, whose lists are part of its time; ours includes the matrix that maps a deformed cage.
The faces of the last surface are kept for the next one that is joined alike: a row says what a first call takes.
"""

import math
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista
import vtk
from geomdl import BSpline
from harness import Contender, Row, calm_threads, medians, table
from pyOpenSubdiv.pysubdivision import pysubdivide
from scipy.spatial import cKDTree
from vtk.util.numpy_support import vtk_to_numpy

import gpu_xform as gx
from gpu_xform.surfaces import function_surfaces, weld
from gpu_xform.surfaces.patch_grids import evaluate_patches

TURN = (0.0, math.tau)
RING = 256
LEVELS = 6
SAMPLES = 10


def torus(u: Any, v: Any) -> Any:
    radius = 1.0 + 0.4 * np.cos(v)
    return radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v)


def make_ours() -> gx.Mesh:
    return gx.parametric(torus, TURN, TURN, (True, True), RING)


def make_first(make: Contender) -> None:
    """Make a surface as if there had been none before."""
    function_surfaces._list_grid_faces.cache_clear()
    weld._weld_numbers.cache_clear()
    make()


def make_geomdl(patches: npt.NDArray[np.float64]) -> list[Any]:
    """Return the points of the teapot's 32 surfaces, evaluated at 10 x 10 parameters each."""
    points = []
    for patch in patches:
        surface = BSpline.Surface()
        surface.degree_u = surface.degree_v = 3
        surface.set_ctrlpts(patch.reshape(-1, 3).tolist(), 4, 4)
        surface.knotvector_u = surface.knotvector_v = [0.0] * 4 + [1.0] * 4
        surface.sample_size = SAMPLES
        surface.evaluate()
        points += surface.evalpts
    return points


def make_vtk() -> Any:
    """Return VTK's torus with points and triangles alone."""
    function, source = vtk.vtkParametricTorus(), vtk.vtkParametricFunctionSource()
    function.SetRingRadius(1.0)
    function.SetCrossSectionRadius(0.4)
    source.SetParametricFunction(function)
    source.SetUResolution(RING + 1)  # points, not steps
    source.SetVResolution(RING + 1)
    source.SetScalarModeToNone()
    source.GenerateNormalsOff()
    source.GenerateTextureCoordinatesOff()
    source.SetOutputPointsPrecision(vtk.vtkAlgorithm.DOUBLE_PRECISION)
    source.Update()
    return source.GetOutput()


def make_opensubdiv(mesh: gx.Mesh) -> Any:
    faces = [face.tolist() for face in mesh.faces]
    sizes = np.diff(mesh.offsets).tolist()
    return pysubdivide(LEVELS, mesh.positions.tolist(), faces, mesh.indices.tolist(), sizes)


def distance(ours: Any, theirs: Any) -> float:
    """Return how far a point of either set is from the nearest one of the other, at most, over the size."""
    ours, theirs = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    gaps = [cKDTree(a).query(b)[0].max() for a, b in ((ours, theirs), (theirs, ours))]
    return float(max(gaps) / np.ptp(ours, axis=0).max())


def require_same(what: str, ours: Any, theirs: Any, at_most: float) -> None:
    found = distance(ours, theirs)
    print(f"{what}: at most {found:.1e} of the size apart")
    if found > at_most:
        raise SystemExit(f"{what}: the points disagree")


def main() -> None:
    calm_threads()
    patches, cube = gx.samples.teapot_patches(), gx.samples.cube()
    teapot = partial(gx.bezier, patches, SAMPLES - 1, normals=False)
    subdivided = partial(gx.subdivide, cube, LEVELS)
    require_same("geomdl", teapot().positions, make_geomdl(patches), 1e-14)
    require_same("VTK", make_ours().positions, vtk_to_numpy(make_vtk().GetPoints().GetData()), 1e-14)
    shown = pyvista.ParametricTorus(1.0, 0.4, u_res=RING + 1, v_res=RING + 1)
    require_same("pyvista", make_ours().positions, shown.points, 2e-6)
    for name, mesh in (("cube", cube), ("house", gx.samples.house())):
        expected = make_opensubdiv(mesh)["vertices"]
        require_same(f"OpenSubdiv, {name}", gx.subdivide(mesh, LEVELS).mesh.positions, expected, 1e-6)
    contenders: dict[str, Contender] = {
        "teapot": teapot,
        "points": partial(evaluate_patches, patches, SAMPLES - 1),
        "with normals": partial(gx.bezier, patches, SAMPLES - 1),
        "geomdl": partial(make_geomdl, patches),
        "torus": make_ours,
        "vtk": make_vtk,
        "pyvista": partial(pyvista.ParametricTorus, 1.0, 0.4, u_res=RING + 1, v_res=RING + 1),
        "cube": lambda: subdivided().matrix,
        "opensubdiv": partial(make_opensubdiv, cube),
        "first teapot": partial(make_first, teapot),
        "first torus": partial(make_first, make_ours),
    }
    seconds = medians(contenders, rounds=9, warm_up=2)
    rows = [
        Row("teapot, 32 x 10 x 10 points", "geomdl, points", seconds["points"], seconds["geomdl"], 0.01),
        Row("the same, welded, as a mesh of quads", "geomdl, points", seconds["teapot"], seconds["geomdl"], 0.01),
        Row("the same, the first time", "geomdl, points", seconds["first teapot"], seconds["geomdl"]),
        Row("the same, with normals", "geomdl, points", seconds["with normals"], seconds["geomdl"]),
        Row("torus, 256 x 256", "VTK as pyvista asks it", seconds["torus"], seconds["pyvista"], 0.2),
        Row("torus, 256 x 256", "VTK, points and triangles alone", seconds["torus"], seconds["vtk"], 0.2),
        Row("the same, the first time", "VTK, points and triangles alone", seconds["first torus"], seconds["vtk"]),
        Row("cube, six levels, with the matrix", "OpenSubdiv", seconds["cube"], seconds["opensubdiv"], 0.3),
    ]
    print(table(rows))


if __name__ == "__main__":
    main()
