"""Pictures of points that are on the device already, and of edges that the caller names."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.drawing.prepare import Frame, prepare_frame
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from gpu_xform.gpu import buffers
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.vector.edge_visibility import split_edges_by_visibility

pytestmark = pytest.mark.usefixtures("rasterizer_name")

HOUSE = gx.samples.house()
EYE, TARGET = (5, 4, 9), (0, 0.5, 0)
CAMERA = gx.Camera.look_at(EYE, TARGET)
SEEN: dict[str, Any] = {"camera": CAMERA, "size": (150, 100)}
TURN = gx.chain(gx.scale(1, 1.5, 0.5), gx.rotate((1, 2, 3), 0.4), gx.translate(0.2, -0.3, 0.1))


def difference(a: npt.NDArray[np.uint8], b: npt.NDArray[np.uint8]) -> int:
    return int(np.abs(a.astype(int) - b).max())


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_buffer_draws_as_its_mesh_does(dtype: npt.DTypeLike) -> None:
    with gx.PointBuffer(HOUSE.positions.astype(dtype)) as points:
        drawn = gx.render_array(points, edges=HOUSE.edges, camera=CAMERA, transform=TURN, size=(300, 200))
    assert difference(drawn, gx.render_array(HOUSE, camera=CAMERA, transform=TURN, size=(300, 200))) <= 1


def test_pending_transforms_are_drawn_without_a_readback(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = gx.render_array(HOUSE.transformed(TURN), camera=CAMERA, size=(300, 200))
    projected = gx.render_array(
        HOUSE, transform=gx.perspective_from_eye(5) @ TURN, camera=gx.Camera.window((-3, 3), (-2, 2)), size=(300, 200)
    )
    with gx.PointBuffer(HOUSE.positions) as points:
        moved = points.transformed(TURN)
        downloaded = buffers.Buffer.map_read
        read: list[int] = []

        def spy(buffer: buffers.Buffer, n_bytes: int) -> Any:
            read.append(n_bytes)
            return downloaded(buffer, n_bytes)

        monkeypatch.setattr(buffers.Buffer, "map_read", spy)
        camera = gx.Camera.look_at(EYE, TARGET, near=1.0, far=100.0)  # without them, it would ask for the bounds
        drawn = gx.render_array(moved, edges=HOUSE.edges, camera=camera, size=(300, 200))
        assert read == [200 * 1280]  # the picture, in rows of 256 bytes, and nothing else
        flat = gx.render_array(
            moved.projected(gx.perspective_from_eye(5)),
            edges=HOUSE.edges,
            camera=gx.Camera.window((-3, 3), (-2, 2)),
            size=(300, 200),
        )
    assert difference(drawn, expected) <= 1
    assert difference(flat, projected) <= 1


def test_a_buffer_far_from_the_origin_keeps_its_shape_in_double() -> None:
    far = gx.translate(4e6, 1e6, 5e6)
    camera = gx.Camera.look_at(np.add((5, 4, 9), (4e6, 1e6, 5e6)), np.add((0, 0.5, 0), (4e6, 1e6, 5e6)))
    with gx.PointBuffer(HOUSE.transformed(far).positions) as points:
        drawn = gx.render_array(points, edges=HOUSE.edges, camera=camera, size=(300, 200))
    assert difference(drawn, gx.render_array(HOUSE, camera=CAMERA, size=(300, 200))) <= 2


def test_a_buffer_is_framed_by_its_box() -> None:
    with gx.PointBuffer(HOUSE.positions) as points:
        drawn = gx.render_array(points.transformed(TURN), edges=HOUSE.edges, size=(300, 200))
    corners = HOUSE.transformed(TURN).bounds
    box = gx.Mesh([[x, y, z] for x in corners[:, 0] for y in corners[:, 1] for z in corners[:, 2]])
    framed = gx.render_array(HOUSE, transform=TURN, camera=gx.Camera.fit(box), size=(300, 200))
    assert difference(drawn, framed) <= 1


def test_edges_of_ones_own_replace_the_meshes() -> None:
    one = gx.render_array(HOUSE, edges=[[0, 1]], camera=CAMERA, size=(300, 200))
    segment = gx.Mesh(HOUSE.positions, [[0, 1]])
    assert difference(one, gx.render_array(segment, camera=CAMERA, size=(300, 200))) <= 1
    assert (one != 255).any()


@pytest.mark.parametrize(
    ("kwargs", "error", "message"),
    [
        ({"edges": [[0, 10]]}, ArgumentError, r"edges names point 10 in row 0, outside 0\.\.9"),
        ({"edges": [[-1, 0]]}, ArgumentError, r"edges names point -1 in row 0, outside 0\.\.9"),
        ({"edges": [0, 1]}, ArgumentError, r"edges must have shape \(m, 2\), got \(2,\)"),
        ({"edges": np.empty((0, 2), int)}, ArgumentError, "at least one pair of points, got none"),
        ({"edges": [[0.0, 1.0]]}, ArgumentTypeError, "edges must hold integers, got dtype float64"),
        ({"edges": [[0, 1]], "color": "face"}, ArgumentError, "need a model with faces"),
        ({"edges": "feature"}, ArgumentError, "edges by name need a model with faces, got 'feature'"),
    ],
)
def test_edges_that_do_not_fit_are_refused(kwargs: dict[str, Any], error: type[Exception], message: str) -> None:
    with gx.PointBuffer(HOUSE.positions.astype(np.float32)) as points, pytest.raises(error, match=message):
        gx.render(points, **kwargs)


def test_faces_have_no_colours_where_edges_are_given() -> None:
    with pytest.raises(ArgumentError, match=r"^edges must be 'all' if each face has its own colour"):
        gx.render(HOUSE, edges=[[0, 1]], color="face")


def test_points_of_the_plane_and_of_another_device_are_refused(staging_device: GpuDevice) -> None:
    with (
        gx.PointBuffer(np.ones((4, 2), np.float32)) as flat,
        pytest.raises(ArgumentError, match=r"shape \(n, 3\), got \(4, 2\)"),
    ):
        gx.render(flat, edges=[[0, 1]])
    with gx.PointBuffer(np.ones((4, 3), np.float32)) as points, pytest.raises(ArgumentError, match="they must be one"):
        gx.render(points, edges=[[0, 1]], camera=CAMERA, device=staging_device)


SPLIT = gx.Mesh(gx.samples.cube().positions, gx.samples.cube().to_trimesh().faces)


def test_the_creases_of_a_triangulated_cube_draw_the_cube() -> None:
    cube = gx.render_array(gx.samples.cube(), camera=CAMERA, size=(300, 200))
    assert np.array_equal(gx.render_array(SPLIT, edges="feature", camera=CAMERA, size=(300, 200)), cube)
    assert not np.array_equal(gx.render_array(SPLIT, camera=CAMERA, size=(300, 200)), cube)
    assert np.array_equal(gx.render_array(SPLIT, edges="all", camera=CAMERA), gx.render_array(SPLIT, camera=CAMERA))


def test_the_angle_says_what_a_crease_is() -> None:
    with pytest.raises(gx.MeshError, match="edges must choose at least one edge, 'feature' chooses none of 18"):
        gx.render(SPLIT, edges="feature", feature_angle=91)
    with pytest.raises(ArgumentError, match=r"feature_angle must be in 0\.\.180 degrees, got 181"):
        gx.render(SPLIT, edges="feature", feature_angle=181)


def test_sets_of_edges_combine() -> None:
    grid = gx.samples.grid(4)
    camera = gx.Camera.window((-1.5, 1.5), (-1, 1))
    boundary = gx.render_array(grid, edges="boundary", camera=camera, size=(300, 200))
    both = gx.render_array(grid, edges=["boundary", [[0, 6]]], camera=camera, size=(300, 200))
    alone = gx.render_array(grid, edges=[[0, 6]], camera=camera, size=(300, 200))
    only_boundary, only_alone = (alone == 255).all(axis=2), (boundary == 255).all(axis=2)
    assert np.array_equal(both[only_boundary], boundary[only_boundary])
    assert np.array_equal(both[only_alone], alone[only_alone])
    assert (alone != 255).any()
    assert (boundary != 255).any()


def test_an_unknown_set_of_edges_is_refused() -> None:
    with pytest.raises(ArgumentError, match="creases"):
        gx.render(SPLIT, edges="creases")


def test_several_arrays_of_edges_are_drawn_one_after_another() -> None:
    edges = HOUSE.edges
    with gx.PointBuffer(HOUSE.positions) as points:
        whole = gx.render_array(points, edges=edges, **SEEN)
        assert gx.render_array(points, edges=[edges], **SEEN).tobytes() == whole.tobytes()
        assert gx.render_array(points, edges=[edges[:3], edges[3:]], **SEEN).tobytes() == whole.tobytes()
        with pytest.raises(ArgumentError, match=r"^edges by name need a model with faces, got 'silhouette'"):
            gx.render_array(points, edges=[edges, "silhouette"], **SEEN)


def test_edges_to_points_that_are_not_numbers_are_not_drawn() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (np.nan, 0, 0), (np.inf, 0, 0), (1, 1, 1)], np.float32)
    edges = [(0, 1), (1, 2), (2, 3), (3, 5), (4, 5), (2, 5)]
    with gx.PointBuffer(points) as some, gx.PointBuffer(points[[0, 1, 2, 5]]) as finite:
        rest = [(0, 1), (1, 2), (2, 3)]
        assert (
            gx.render_array(some, edges=edges, **SEEN).tobytes()
            == gx.render_array(finite, edges=rest, **SEEN).tobytes()
        )
        assert gx.render_svg(some, edges=edges, **SEEN) == gx.render_svg(finite, edges=rest, **SEEN)
        with pytest.raises(MeshError, match=r"^models must have finite points with w > 0 to be framed; give a camera"):
            gx.render_array(some, edges=edges)


def test_edges_to_points_that_are_not_numbers_are_not_sampled() -> None:
    """Their steps would be counted between any two numbers: on some devices, until the system resets them."""
    none = np.array([(0, 0, 0), (np.nan, 0, 0), (np.inf, 0, 0), (-np.inf, 0, 0), (3e38, -3e38, 3e38)], np.float32)
    edges = [(i, j) for i in range(5) for j in range(5) if i != j]
    with (
        gx.PointBuffer(none) as points,
        prepare_frame(points, Frame(CAMERA, (150, 100)), {"edges": edges, "line_width": 2.0}) as prepared,
    ):
        drawables = prepared.draw_list.drawables
        (split,), _ = split_edges_by_visibility(
            prepared.device, drawables, prepared.view, lambda _: 150.0, find_visible=False
        )
    assert np.isfinite(split.spans["ends"]).all()
    assert len(split.spans) <= 2


@pytest.mark.parametrize("orthographic", [True, False])
@pytest.mark.parametrize("outlier", [np.nan, np.inf])
def test_points_that_are_not_numbers_cut_nothing_off_in_parallel_views(outlier: float, orthographic: bool) -> None:
    cloud = np.random.default_rng(7).uniform(-1.0, 1.0, (60, 3)).astype(np.float32) + np.array([0, 0, 40], np.float32)
    with_outliers = np.concatenate([cloud, np.array([(outlier, 0, 0), (0, outlier, outlier)], np.float32)])
    camera = gx.Camera.window((-1.2, 1.2), (-1.2, 1.2))
    if orthographic:
        camera = gx.Camera.look_at((0, 0, 45), (0, 0, 0), fov_y=4.0, orthographic=True)
    wall = gx.Layer(gx.samples.cube(), hidden="remove")  # 39 before it
    options: dict[str, Any] = {"camera": camera, "size": (90, 90)}
    styles: list[dict[str, Any]] = [{}, {"depth_cue": 0.8}, {"hidden": "remove", "point_size": 5.0}]
    with gx.PointBuffer(with_outliers) as some, gx.PointBuffer(cloud) as finite:
        for style in styles:
            shown = gx.render_array(some, **options, **style)
            assert (shown != 255).any(axis=2).sum() > 30
            assert np.array_equal(shown, gx.render_array(finite, **options, **style))
            shown = gx.render_array([wall, some], **options, **style)
            assert np.array_equal(shown, gx.render_array([wall, finite], **options, **style))
        with pytest.raises(MeshError, match=r"^models must have finite points with w > 0 to be framed; give a camera"):
            gx.render_array(some)
