"""Models of other libraries: trimesh and meshio themselves, and the attributes that PyVista and Open3D document."""

from types import SimpleNamespace
from typing import Any

import meshio
import numpy as np
import pytest
import trimesh

import gpu_xform as gx
from gpu_xform.geometry.foreign_meshes import mesh_of_other_library

POINTS = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (1, 3, 1)], dtype=np.float64)
COLORS = np.arange(15, dtype=np.float64).reshape(5, 3) / 15
FACES = [[0, 1, 2, 3], [0, 1, 4]]


def polydata(faces: list[list[int]] = FACES, lines: list[list[int]] | None = None) -> Any:
    """Return what has the attributes of a `pyvista.PolyData`."""
    lines = lines or []
    counted = [np.array([x for row in rows for x in (len(row), *row)], dtype=np.int64) for rows in (faces, lines)]
    cell_data = {} if lines else {"part": np.arange(len(faces))}
    return SimpleNamespace(
        points=POINTS,
        faces=counted[0],
        lines=counted[1],
        n_cells=len(faces) + len(lines),
        point_data={"height": POINTS[:, 2]},
        cell_data=cell_data,
    )


def test_polydata_keeps_polygons_lines_and_attributes() -> None:
    mesh = mesh_of_other_library(polydata())
    assert mesh is not None
    assert mesh == gx.Mesh(
        POINTS, FACES, attributes={"point": {"height": POINTS[:, 2]}, "face": {"part": np.arange(2)}}
    )
    with_lines = mesh_of_other_library(polydata([[0, 1, 2], [0, 2, 3]], [[0, 4, 2]]))
    assert with_lines == gx.Mesh(
        POINTS, [[0, 1, 2], [0, 2, 3], [0, 4], [4, 2]], attributes={"point": {"height": POINTS[:, 2]}}
    )


def test_strips_of_polydata_become_triangles_that_all_turn_one_way() -> None:
    strip = [0, 1, 3, 2, 4, 4]  # the last triangle is flat
    data = polydata([[0, 1, 4]])
    data.strips = np.array([len(strip), *strip])
    data.n_cells, data.cell_data = 2, {"part": np.array([7, 9])}
    mesh = mesh_of_other_library(data)
    assert mesh is not None
    assert [list(face) for face in mesh.faces] == [[0, 1, 4], [0, 1, 3], [3, 1, 2], [3, 2, 4]]
    assert mesh.attributes.face["part"].tolist() == [7, 9, 9, 9]


@pytest.mark.parametrize("kind", ["ImageData", "UnstructuredGrid"])
def test_volumes_of_pyvista_are_refused(kind: str) -> None:
    names = ("extract_surface", "points", "cells", "point_data", "cell_data")
    data = type(kind, (), dict.fromkeys(names))()
    with pytest.raises(gx.MeshError, match=rf"^{kind} of PyVista is no surface: draw what its extract_surface\(\)"):
        gx.Layer(data)


def test_meshio_keeps_faces_and_lines_and_refuses_volumes() -> None:
    mixed = meshio.Mesh(POINTS, [("quad", FACES[:1]), ("triangle", FACES[1:]), ("line", [[3, 4]]), ("vertex", [[2]])])
    mixed.point_data["height"] = POINTS[:, 2]
    assert mesh_of_other_library(mixed) == gx.Mesh(
        POINTS, [*FACES, [3, 4]], attributes={"point": {"height": POINTS[:, 2]}}
    )
    second_order = meshio.Mesh(np.vstack((POINTS, POINTS + 9)), [("triangle6", [[0, 1, 2, 5, 6, 7]])])
    assert [list(face) for face in gx.Layer(second_order).model.faces] == [[0, 1, 2]]  # type: ignore[union-attr]
    flat = mesh_of_other_library(meshio.Mesh(POINTS[:, :2], [("triangle", FACES[1:])]))
    assert flat is not None
    assert np.array_equal(flat.positions, POINTS * (1, 1, 0))
    with pytest.raises(gx.MeshError, match="got tetra: extract its surface first"):
        mesh_of_other_library(meshio.Mesh(POINTS, [("tetra", [[0, 1, 2, 4]])]))


def test_open3d_keeps_triangles_lines_and_colours() -> None:
    triangles = SimpleNamespace(vertices=POINTS, triangles=np.array(FACES[1:]), vertex_colors=COLORS)
    assert mesh_of_other_library(triangles) == gx.Mesh(POINTS, FACES[1:], attributes={"point": {"color": COLORS}})
    lines = SimpleNamespace(points=POINTS, lines=np.array([[0, 4], [4, 2]]), colors=COLORS[:2])
    assert mesh_of_other_library(lines) == gx.Mesh(POINTS, [[0, 4], [4, 2]])
    cloud = SimpleNamespace(points=POINTS, colors=np.zeros((0, 3)), covariances=[])
    assert mesh_of_other_library(cloud) == gx.Mesh(POINTS)


def test_trimesh_keeps_its_colours() -> None:
    box = trimesh.creation.box()
    plain = mesh_of_other_library(box)
    assert plain is not None
    assert plain.attributes.point == {}
    box.visual.vertex_colors = np.arange(32, dtype=np.uint8).reshape(8, 4)
    colored = mesh_of_other_library(box)
    assert colored is not None
    assert np.array_equal(colored.attributes.point["color"], np.arange(32).reshape(8, 4))
    path: Any = trimesh.load_path(POINTS[[0, 1, 4]])
    found = mesh_of_other_library(path)
    assert found is not None
    assert np.array_equal(found.positions[found.edges], POINTS[[[0, 1], [1, 4]]])


@pytest.mark.parametrize("thing", [3, None, "points", gx.samples.cube(), POINTS, object(), SimpleNamespace(points=1)])
def test_other_things_are_left_alone(thing: object) -> None:
    assert mesh_of_other_library(thing) is None


def test_all_that_draws_takes_them() -> None:
    box = trimesh.creation.box()
    own = gx.Mesh.from_trimesh(box)
    camera = gx.Camera.fit(own)
    expected = gx.render_array(own, size=(40, 30), camera=camera)
    scene = trimesh.Scene([box])
    for models in (box, [box], gx.Layer(box), scene, [scene]):
        assert np.array_equal(gx.render_array(models, size=(40, 30), camera=camera), expected)  # type: ignore[arg-type]
    frames: Any = [box, scene, np.eye(4)]
    for frame in gx.animate(box, frames, size=(40, 30), camera=camera):
        assert np.array_equal(np.asarray(frame), expected)
    assert "<path" in gx.render_svg(scene)  # type: ignore[arg-type]
