"""Decimation keeps a mesh's shape and its faces' data within a number of edges."""

import re
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import ArgumentError
from gpu_xform.web.decimation import decimate, decimate_layers

BALL = gx.samples.icosphere(4)


@pytest.mark.parametrize("max_edges", [30, 500, 5000])
@pytest.mark.parametrize("mesh", [BALL, gx.samples.torus(60, 40)])
def test_a_mesh_keeps_its_shape_within_a_number_of_edges(mesh: gx.Mesh, max_edges: int) -> None:
    found = decimate(mesh, max_edges).mesh
    assert 0.4 * max_edges < len(found.edges) <= max_edges
    cell = 2.0 * np.ptp(mesh.bounds, axis=0).max() / np.sqrt(max_edges / 3.0)
    assert np.abs(found.bounds - mesh.bounds).max() < cell


def test_points_and_faces_name_those_that_they_stand_for() -> None:
    found = decimate(BALL, 900)
    near = BALL.positions[found.points]
    assert np.linalg.norm(near - found.mesh.positions, axis=1).max() < 0.25
    centres = [mesh.positions[np.asarray(mesh.faces)].mean(axis=1) for mesh in (found.mesh, BALL)]
    assert np.linalg.norm(centres[0] - centres[1][found.faces], axis=1).max() < 0.25


def test_segments_stay_segments() -> None:
    line = gx.Mesh(np.column_stack([np.linspace(0, 1, 101), np.zeros((101, 2))]), [(i, i + 1) for i in range(100)])
    found = decimate(line, 20).mesh
    assert 5 < len(found.edges) <= 20
    assert (np.diff(found.offsets) == 2).all()


def test_layers_share_the_number_and_keep_their_colours() -> None:
    scalars = BALL.positions[:, 2]
    heights = np.clip(BALL.positions[np.asarray(BALL.faces)].mean(axis=1) * 0.5 + 0.5, 0, 1)
    layers = [gx.Layer(BALL, scalars=scalars, fill=heights), gx.Layer(gx.samples.cube())]
    ball, cube = decimate_layers(layers, 600)
    assert isinstance(ball.model, gx.Mesh)
    assert isinstance(cube.model, gx.Mesh)
    assert len(ball.model.edges) + len(cube.model.edges) <= 600
    assert np.abs(np.asarray(ball.scalars) - ball.model.positions[:, 2]).max() < 0.3
    assert len(ball.fill) == ball.model.n_faces


@pytest.mark.parametrize(
    ("options", "max_edges", "message"),
    [
        ({"edges": [(0, 1)]}, 100, "max_edges cannot go with edges by index"),
        ({"edge_colors": np.zeros((len(BALL.edges), 3))}, 100, "max_edges cannot go with edge_colors"),
        ({}, 1, "max_edges must leave some edges of each model, got 1"),
        ({}, 0, "max_edges must be at least 1, got 0"),
    ],
)
def test_what_cannot_be_decimated(options: dict[str, Any], max_edges: int, message: str, tmp_path: Any) -> None:
    with pytest.raises(ArgumentError, match=re.escape(message)):
        gx.save_page(BALL, tmp_path / "ball.html", size=(32, 32), max_edges=max_edges, **options)
    assert not list(tmp_path.iterdir())
