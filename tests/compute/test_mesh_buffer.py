"""Mesh buffers: what is drawn of a mesh whose points are on the device is what is drawn of the mesh."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.device import Device
from tests.support.reference_transform import AFFINE, PROJECTIVE

HOUSE = gx.samples.house()
BALL = gx.samples.icosphere(2)
CAMERA = gx.Camera.fit(BALL)
ROUNDING = 3  # of 255: positions are rounded to float32 in another frame


@pytest.mark.parametrize(
    "style",
    [
        {},
        {"hidden": "remove"},
        {"hidden": "dash", "fill": "face"},
        {"color": "face"},
        {"edges": "silhouette", "hidden": "remove"},
        {"edges": "feature", "feature_angle": 10.0},
        {"edges": [[0, 5], [3, 7]]},
        {"edges": ["silhouette", [[0, 5]]], "point_size": 3.0},
        {"scalars": "y"},
    ],
    ids=str,
)
def test_it_is_drawn_as_its_mesh(style: dict[str, Any], device: Device) -> None:
    arguments: dict[str, Any] = {"camera": CAMERA, "size": (160, 120), **style}
    with gx.MeshBuffer(BALL, device=device) as buffer:
        drawn, expected = gx.render_array(buffer, **arguments), gx.render_array(BALL, **arguments)
        assert np.abs(drawn.astype(int) - expected).max() <= ROUNDING
        assert len(np.unique(expected)) > 2
        assert gx.render_svg(buffer, **arguments).count("<path") == gx.render_svg(BALL, **arguments).count("<path")


def test_what_is_transformed_is_drawn_where_it_is(device: Device) -> None:
    arguments: dict[str, Any] = {"camera": gx.Camera.fit(HOUSE.transformed(AFFINE)), "size": (160, 120)}
    styles: list[dict[str, Any]] = [{"hidden": "remove"}, {"edges": "silhouette"}, {"scalars": "x"}]
    with gx.MeshBuffer(HOUSE, device=device) as buffer:
        moved = buffer.transformed(AFFINE)
        assert isinstance(moved, gx.MeshBuffer)
        for style in styles:
            drawn, expected = (
                gx.render_array(model, **arguments, **style) for model in (moved, HOUSE.transformed(AFFINE))
            )
            assert np.abs(drawn.astype(int) - expected).max() <= ROUNDING
        np.testing.assert_allclose(moved.mesh.positions, HOUSE.transformed(AFFINE).positions, rtol=1e-6, atol=1e-6)
        assert moved.topology is HOUSE
        np.testing.assert_array_equal(buffer.bounds(), HOUSE.bounds)
        np.testing.assert_allclose(moved.bounds(), HOUSE.transformed(AFFINE).bounds, rtol=1e-6, atol=1e-6)
        assert len(buffer.projected(PROJECTIVE).numpy()) == HOUSE.n_points


def test_edges_and_faces_are_uploaded_once(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    first = gx.MeshBuffer(HOUSE, device=device)
    second = gx.MeshBuffer(HOUSE, device=device).transformed(AFFINE)
    gx.render_array(first, hidden="remove")

    def refuse(*_: object) -> None:
        raise AssertionError("triangles are found again")

    monkeypatch.setattr("gpu_xform.drawing.geometry_source.triangulate", refuse)
    gx.render_array(second, hidden="remove")


def test_what_is_no_mesh_is_an_error() -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"^mesh must be a Mesh, got ndarray$"):
        gx.MeshBuffer(HOUSE.positions)  # type: ignore[arg-type]


def test_it_says_what_it_is() -> None:
    with gx.MeshBuffer(HOUSE) as buffer:
        assert repr(buffer).startswith(f"<MeshBuffer: {HOUSE.n_points} points, {HOUSE.n_faces} faces on ")
