"""Arrays with a mask, and those that no memory holds."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform._core.masked import drop_hidden_rows, fill_hidden_rows, find_hidden_rows
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError

GRID = np.array([[x, y, 0.0] for y in range(3) for x in range(4)])
HIDDEN = 5
SHOWN = np.delete(GRID, HIDDEN, axis=0)
MATRIX = gx.translate(1, 2, 3) @ gx.scale(2, 3, 4)
SEEN: dict[str, Any] = {"camera": {"direction": (0, 0, -1)}, "size": (80, 64), "point_size": 5}


def masked(dtype: type = np.float64) -> Any:
    """Return the grid with one coordinate of a row hidden, and a fill value there that would not go unnoticed."""
    values: Any = GRID.astype(dtype)
    values[HIDDEN] = 9.96921e36 if np.dtype(dtype).kind == "f" else 2**30
    mask = np.zeros(values.shape, bool)
    mask[HIDDEN, 1] = True
    return np.ma.MaskedArray(values, mask)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64])
def test_hidden_rows_stay_hidden_in_what_is_transformed(dtype: type) -> None:
    result: Any = gx.transform_points(masked(dtype), MATRIX)
    expected = gx.transform_points(GRID.astype(dtype), MATRIX)
    assert isinstance(result, np.ma.MaskedArray)
    assert np.ma.getmaskarray(result).all(axis=1).tolist() == [row == HIDDEN for row in range(12)]
    assert np.array_equal(result.compressed().reshape(-1, 3), np.delete(expected, HIDDEN, axis=0))


def test_all_bulk_functions_and_stacks_of_matrices() -> None:
    points = masked()
    for function in (gx.transform_vectors, gx.transform_normals, gx.project_points):
        result = function(points, np.stack([MATRIX, np.eye(4)]))
        assert result.shape == (2, 12, 3)
        assert np.ma.getmaskarray(result)[:, HIDDEN].all()
        assert np.ma.getmaskarray(result).sum() == 6
    index = np.zeros(12, np.int64)
    assert np.ma.getmaskarray(gx.transform_points(points, MATRIX[None], index=index)).sum() == 3
    with pytest.raises(gx.ArgumentError, match="index must have no masked entries, got 1 of 12"):
        gx.transform_points(GRID, MATRIX[None], index=np.ma.masked_array(index, np.arange(12) == 3))


def test_arrays_to_write_to() -> None:
    out = np.zeros((12, 3))
    assert gx.transform_points(masked(), MATRIX, out=out) is out
    assert np.isnan(out).sum() == 3
    own: Any = masked()
    result = gx.transform_points(own, MATRIX, out=own)
    assert result is own
    assert np.ma.getmaskarray(own).sum() == 3
    assert np.array_equal(np.ma.compressed(own).reshape(-1, 3), gx.transform_points(SHOWN, MATRIX))


def test_an_array_that_hides_everything_or_nothing() -> None:
    everything: Any = np.ma.MaskedArray(np.zeros((4, 3)), True)
    assert np.ma.getmaskarray(gx.transform_points(everything, MATRIX)).all()
    with pytest.raises(gx.ArgumentError, match="at least one point"):
        gx.bounds(everything)
    nothing = np.ma.MaskedArray(GRID)
    assert not isinstance(gx.transform_points(nothing, MATRIX), np.ma.MaskedArray)


def test_hidden_rows_have_no_part_in_bounds() -> None:
    assert np.array_equal(gx.bounds(masked()), gx.bounds(SHOWN))
    with gx.PointBuffer(masked(np.float32)) as buffer:
        assert np.array_equal(buffer.numpy(), SHOWN.astype(np.float32))


def test_hidden_rows_are_not_drawn_and_not_framed() -> None:
    expected = gx.render_array(SHOWN, **SEEN)
    assert np.array_equal(gx.render_array(masked(), **SEEN), expected)
    layer = gx.Layer(masked(), point_size=5)
    assert np.array_equal(gx.render_array(layer, camera=SEEN["camera"], size=SEEN["size"]), expected)
    scene = gx.Scene()
    scene.add(masked(), name="points")
    assert np.array_equal(gx.render_array(scene, **SEEN), expected)
    assert gx.Mesh(masked()) == gx.Mesh(SHOWN)
    assert gx.render_svg(masked(), **SEEN) == gx.render_svg(SHOWN, **SEEN)


def test_colours_of_hidden_points_are_left_out() -> None:
    scalars = np.arange(12.0)
    scalars[HIDDEN] = 1e9
    expected = gx.render_array(SHOWN, scalars=np.delete(scalars, HIDDEN), **SEEN)
    assert np.array_equal(gx.render_array(masked(), scalars=scalars, **SEEN), expected)
    names = ["red", "blue", "green"] * 4
    expected = gx.render_array(SHOWN, vertex_colors=names[:HIDDEN] + names[HIDDEN + 1 :], **SEEN)
    assert np.array_equal(gx.render_array(masked(), vertex_colors=names, **SEEN), expected)
    with pytest.raises(gx.ArgumentError, match="edges must not be given by indices for a masked array of points"):
        gx.render_array(masked(), edges=[(0, 1)], **SEEN)


def test_an_animation_leaves_them_out(tmp_path: Path) -> None:
    frames = [np.eye(4), gx.rotate_z(90, degrees=True)]
    scalars = np.arange(12.0)
    gx.animate(masked(), frames, tmp_path / "a.gif", scalars=scalars, **SEEN)
    gx.animate(SHOWN, frames, tmp_path / "b.gif", scalars=np.delete(scalars, HIDDEN), **SEEN)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_what_cannot_do_without_a_number_is_refused() -> None:
    hole = np.ma.masked_array(np.eye(4), np.eye(4) == 1)
    with pytest.raises(gx.ArgumentError, match="matrix must have no masked entries, got 4 of 16"):
        gx.transform_points(GRID, hole)
    with pytest.raises(gx.MeshError, match="positions must have no masked entries, got 1 of 36"):
        gx.Mesh(masked(), [(0, 1, 5)])
    with pytest.raises(gx.MeshError, match="faces must have no masked entries"):
        gx.Mesh(GRID, np.ma.masked_array([[0, 1, 2]], [[True, False, False]]))


def test_plain_arrays_are_passed_on() -> None:
    assert drop_hidden_rows(GRID) is GRID
    assert fill_hidden_rows(GRID) is GRID
    assert find_hidden_rows([[1, 2, 3]]) is None


HUGE = (10**12, 3)
PICTURE = np.zeros((2, 2, 4), np.uint8)


def make_huge(kind: str, dtype: type) -> Any:
    """An array of 24 TB that takes no memory: lazy, or a number that is repeated."""
    if kind == "dask":
        import dask.array

        return dask.array.zeros(HUGE, dtype=dtype, chunks=(10**10, 3))
    return np.broadcast_to(np.zeros((), dtype), HUGE)


@pytest.mark.parametrize("kind", ["dask", "broadcast"])
@pytest.mark.parametrize(
    ("dtype", "call"),
    [
        (float, gx.Mesh),
        (int, lambda rows: gx.Mesh(np.zeros((4, 3)), rows)),
        (int, lambda rows: gx.Mesh.from_offsets(np.zeros((4, 3)), [0, 3], rows[:, 0])),
        (float, gx.Camera.fit),
        (float, lambda rows: gx.transform_points(rows, np.eye(4))),
        (int, lambda rows: gx.transform_points(np.zeros((4, 3)), np.stack([np.eye(4)] * 2), index=rows[:, 0])),
        (float, lambda rows: gx.Attributes(point={"x": rows})),
        (float, lambda rows: gx.convolve(rows, np.ones((3, 3)))),
        (float, gx.Strands),
        (float, lambda rows: gx.render_array(rows, size=(8, 8))),
        (int, lambda rows: gx.render_array(gx.samples.cube(), edges=rows[:, :2], size=(8, 8))),
        (float, lambda rows: gx.render_array(gx.samples.cube(), scalars=rows[:, 0], size=(8, 8))),
        (float, lambda rows: gx.render_array(gx.samples.cube(), vertex_colors=rows, size=(8, 8))),
        (np.str_, lambda rows: gx.render_array(gx.samples.cube(), labels=rows[:, 0], size=(8, 8))),
        (np.str_, lambda rows: gx.Attributes(labels={"x": rows[:, 0]})),
        (np.uint8, lambda rows: gx.compare_images(rows[:, np.newaxis], PICTURE)),
        (np.uint8, lambda rows: gx.compare_images(PICTURE, rows[:, np.newaxis])),
    ],
)
def test_arrays_that_no_memory_holds_are_refused_by_their_shape(
    kind: str, dtype: type, call: Callable[[Any], Any]
) -> None:
    words = (
        r"must take at most 274,877,906,944 bytes, got shape|a mesh holds at most|must be in memory, got a dask array"
        r"|labels must be 'names', 'indices', a text per point, or a dict from points to texts, got Array"
    )
    with pytest.raises((ArgumentError, ArgumentTypeError, MeshError), match=words):
        call(make_huge(kind, dtype))


def test_pictures_that_are_lazy_or_masked_are_as_other_arrays() -> None:
    import dask.array

    array: Any = dask.array
    lazy = array.from_array(PICTURE, chunks=1)
    assert gx.compare_images(lazy, lazy).n_pixels == 0
    masked_picture = np.ma.masked_array(PICTURE, PICTURE == 1)
    assert gx.compare_images(masked_picture, PICTURE).n_pixels == 0
    masked_picture[0, 0, 0] = np.ma.masked
    with pytest.raises(ArgumentError, match="reference must have no masked entries, got 1 of 16"):
        gx.compare_images(PICTURE, masked_picture)


def test_a_small_lazy_array_is_computed_even_if_its_size_is_unknown() -> None:
    import dask.array

    points = np.arange(12.0).reshape(4, 3)
    array: Any = dask.array
    lazy = array.from_array(points, chunks=2)
    np.testing.assert_array_equal(gx.Mesh(lazy[lazy[:, 0] > 2]).positions, points[1:])
    assert len(gx.Mesh(points, array.from_array(np.array([[0, 1, 2], [1, 2, 3]]))).faces) == 2
