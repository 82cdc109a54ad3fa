import io
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gpu_xform import samples
from gpu_xform.errors import MeshError
from gpu_xform.formats import load_mesh, load_scene, save_mesh
from gpu_xform.geometry.mesh import Mesh

POINTS = np.array([[1.0, 2, 3], [-4, 5, -6], [0.125, 0, 7], [1e6, -1e-6, 3]])


def as_file(array: npt.NDArray[Any], *, version: tuple[int, int] | None = None) -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array(file, array, version=version)
    return file.getvalue()


def read(data: bytes) -> Mesh:
    return load_mesh(io.BytesIO(data), file_type="npy")


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
@pytest.mark.parametrize("dtype", ["<f2", "<f4", ">f4", "<f8", ">f8", "i1", ">i4", "<u8"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_of_any_numbers_become_clouds(version: tuple[int, int], dtype: str, order: Any) -> None:
    points = np.array([[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]], dtype, order=order)
    cloud = read(as_file(points, version=version))
    assert cloud.n_faces == 0
    assert cloud.positions.tolist() == points.astype(float).tolist()


@given(arrays.arrays(np.float64, st.tuples(st.integers(1, 9), st.just(3)), elements=st.floats(-1e308, 1e308)))
def test_every_bit_of_a_cloud_comes_back(points: npt.NDArray[np.float64]) -> None:
    file = io.BytesIO()
    save_mesh(Mesh(points), file, file_type="npy")
    file.seek(0)
    array = np.load(file, allow_pickle=False)
    assert array.shape == points.shape
    assert array.tobytes() == points.tobytes()
    assert read(file.getvalue()) == Mesh(points)


def test_a_mesh_with_faces_is_refused_before_a_byte_is_written() -> None:
    for mesh, faces in ((samples.house(), "7"), (Mesh(POINTS, [(0, 1)]), "1"), (samples.grid(40), "1,600")):
        file = io.BytesIO()
        with pytest.raises(MeshError) as caught:
            save_mesh(mesh, file, file_type="npy")
        assert str(caught.value) == (
            f"<file>: NPY holds points only, and would lose the faces of this mesh, {faces} of them"
        )
        assert file.getvalue() == b""


def test_a_scene_of_a_cloud_is_one_node(tmp_path: Any) -> None:
    np.save(tmp_path / "cloud.npy", POINTS)
    (node,) = load_scene(tmp_path / "cloud.npy")
    assert node.name == "cloud"
    assert node.models[0].model == Mesh(POINTS)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (POINTS[:, :2], r"positions must have shape \(n, 3\), got \(4, 2\)"),
        (POINTS[None], r"positions must have shape \(n, 3\), got \(1, 4, 3\)"),
        (POINTS * 1j, "positions must hold real numbers, got dtype complex128"),
        (POINTS > 0, "positions must hold real numbers, got dtype bool"),
        (np.array([["a", "b", "c"]]), "positions must hold real numbers, got dtype <U1"),
        (np.zeros(4, [("x", "f4")]), r"positions must have shape \(n, 3\), got \(4,\)"),
        (np.where(POINTS == 7, np.nan, POINTS), r"positions must be finite, got nan at index \(2, 2\)"),
        (np.empty((0, 3)), "the file holds no points"),
        (np.array([[None] * 3]), "not an .npy file of numbers: it holds Python's objects"),
    ],
)
def test_what_holds_no_points_is_refused(array: npt.NDArray[Any], message: str) -> None:
    with pytest.raises(MeshError, match=f"^<file>: {message}$"):
        read(as_file(array))


def test_nothing_is_unpickled() -> None:
    class Trap:
        def __reduce__(self) -> Any:
            return pytest.fail, ("unpickled",)

    with pytest.raises(MeshError, match="it holds Python's objects"):
        read(as_file(np.array([[Trap()] * 3])))


def test_a_header_cannot_declare_more_than_the_file_holds() -> None:
    whole = as_file(POINTS)
    for count in (3, 5, 10**17, 10**29, -4):
        shape = b"(%d, 3), }" % count
        data = whole.replace(b"(4, 3), }" + b" " * (len(shape) - 9), shape)
        with pytest.raises(MeshError, match=f"the header declares {24 * count:,} bytes, got 96$"):
            read(data)
    for data in (whole[:-1], whole + b"\0"):
        with pytest.raises(MeshError, match=f"the header declares 96 bytes, got {len(data) - len(whole) + 96}$"):
            read(data)


SNIPPETS = [*b"()[]{}'\",:-+0123456789 \n#eEjJLxofbrTuFalse\\\0<>|=OUVSM", 0x80, 0xFF]


@given(st.lists(st.tuples(st.integers(0, 127), st.sampled_from(SNIPPETS)), min_size=1, max_size=4), st.integers(0, 300))
def test_damage_gives_a_cloud_or_a_mesh_error(changes: list[tuple[int, int]], end: int) -> None:
    data = bytearray(as_file(POINTS))
    for place, byte in changes:
        data[place] = byte
    try:
        cloud = read(bytes(data[:end]))
    except MeshError:
        pass
    else:
        assert 0 < cloud.n_points <= 32
        assert np.isfinite(cloud.positions).all()


def test_a_header_that_numpy_calls_large_is_refused_in_one_line() -> None:
    header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (3, 3), }".ljust(20_000) + b"\n"
    data = b"\x93NUMPY\x02\x00" + len(header).to_bytes(4, "little") + header + bytes(36)
    with pytest.raises(
        MeshError, match=r"not an \.npy file of numbers: Header info length \(20001\) is large"
    ) as caught:
        read(data)
    assert "\n" not in str(caught.value)
    assert "allow_pickle" not in str(caught.value)


@pytest.mark.parametrize(("shape", "line"), [(b"(4<3) ", 1), (b"\n(4<3)", 2)])
def test_a_header_of_operators_is_the_same_error_each_time(shape: bytes, line: int) -> None:
    data = as_file(POINTS).replace(b"(4, 3)", shape)
    with pytest.raises(MeshError, match=rf"not an \.npy file of numbers: malformed node or string on line {line}$"):
        read(data)
