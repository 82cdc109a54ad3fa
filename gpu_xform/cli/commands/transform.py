"""`gpu-xform transform`: model files and arrays of points, transformed or converted."""

import argparse
import contextlib
import warnings

import numpy as np

from ..._core.types import Float64Array
from ...errors import ArgumentError, ArgumentTypeError, MeshError, MeshWarning
from ...geometry.attributes import Attributes
from ...geometry.mesh import Mesh, move
from .. import argument_types as types
from .. import files
from .. import options as groups
from ..arguments_from_options import choose_device, compose_transforms
from ..paths import STDIO, file_type, require_target, require_type
from ..streams import name_file_in_errors, raise_warnings

AFFINE_LAST_ROW = (0.0, 0.0, 0.0, 1.0)

USAGE = "IN OUT [options]"
DESCRIPTION = """\
Transform the points of a model, whose polygons and attributes stay, or of an
array. Models are transformed in double precision, arrays in their own. What OUT
cannot hold is named on standard error."""
EPILOG = """\
IN and OUT are model files, of the same or of different types; an .npy file of
points (n, 3) is one of them. From .npy to .npy, the points may also be (n, 2),
and the array larger than memory: an interrupted run leaves its results beside
OUT, in OUT.partial, and --resume continues from there. Without transforms, the
file is converted.

examples:
  gpu-xform transform in.obj out.ply --scale 0.3 --translate -0.5,2,0
  gpu-xform transform cloud.npy cloud.npy --matrix pose.txt
  gpu-xform transform cube.off flat.off --perspective-from-eye 5 --project
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `transform`."""
    group = parser.add_argument_group("files")
    group.add_argument(
        "input", metavar="IN", type=types.parse_file_path, help="a model file or an .npy file; - for standard input"
    )
    group.add_argument(
        "output",
        metavar="OUT",
        type=types.parse_file_path,
        help="the result; - for standard output, in the type of IN",
    )
    groups.add_reading_options(group)
    group.add_argument(
        "--strict", action="store_true", help="fail, and write nothing, if the result cannot hold all that IN holds"
    )
    group.add_argument("--resume", action="store_true", help="continue an interrupted run, from .npy to .npy")
    groups.add_transforms(parser).add_argument(
        "--project", action="store_true", help="divide by w, which perspective needs"
    )
    groups.add_general_options(parser, adapter=True)


def run(options: argparse.Namespace) -> int:
    """Transform or convert a model file or an array."""
    require_target(options.output)
    source = file_type(options.input, options.file_type)
    target = source if options.output == STDIO else file_type(options.output)
    matrix = compose_transforms(options)
    if not options.project and tuple(matrix[3]) != AFFINE_LAST_ROW:
        raise ArgumentError("the transforms are projective: give --project to divide the points by w")
    if source == target == "npy":
        _transform_array(options, matrix)
    else:
        if options.resume:
            raise ArgumentError("--resume is for .npy files that become .npy files")
        from ...formats.registry import WRITERS

        require_type(options.output, tuple(sorted(WRITERS)), target)
        with raise_warnings() if options.strict else contextlib.nullcontext():
            _transform_mesh(options, matrix, target)
    return 0


def _transform_mesh(options: argparse.Namespace, matrix: Float64Array, target: str) -> None:
    from ...compute.transform import project_points, transform_points
    from ...formats.registry import DOCUMENT_TYPES, transform_document

    source = file_type(options.input, options.file_type)
    if {source, target} <= set(DOCUMENT_TYPES) and not options.project:
        with name_file_in_errors(options.output):
            transform_document(
                files.open_source(options.input),
                files.open_target(options.output),
                matrix,
                source_type=source,
                target_type=target,
            )
        return
    mesh = files.read_mesh(options.input, options.file_type, options.tolerance)
    run = project_points if options.project else transform_points
    positions = run(mesh.positions, matrix, device=choose_device(options))
    if options.project:
        mesh = _without_directions(mesh)
    try:
        moved = move(mesh, positions, matrix)
    except MeshError as error:  # a coordinate has overflowed, or was divided by w = 0
        raise MeshError(f"{options.input}, transformed: {error}") from None
    files.write_mesh(_name_polygons(moved, target), options.output, target)


def _name_polygons(mesh: Mesh, target: str) -> Mesh:
    """Return the mesh with a note, for the line about losses, of the polygons that the format splits into triangles."""
    from ...formats.registry import TRIANGLE_TYPES

    n_polygons = int((np.diff(mesh.offsets) > 3).sum())
    if target not in TRIANGLE_TYPES or n_polygons == 0:
        return mesh
    note = f"{n_polygons} polygon{'s' if n_polygons > 1 else ''} of more than three corners, which become triangles"
    return mesh.with_attributes(mesh.attributes, metadata={**mesh.metadata, "polygons": {"holds": [note]}})


def _without_directions(mesh: Mesh) -> Mesh:
    """Return a mesh without normals and tangents, which a projection bends, with a warning if it had any."""
    attributes = mesh.attributes
    tables, lost = [], []
    for what, table in (("point", attributes.point), ("corner", attributes.corner), ("face", attributes.face)):
        tables.append({name: column for name, column in table.items() if name not in ("normal", "tangent")})
        lost += [f"{name} per {what}" for name in table if name not in tables[-1]]
    if not lost:
        return mesh
    warnings.warn(f"a projection does not keep {', '.join(lost)}", MeshWarning, stacklevel=2)
    return mesh.with_attributes(Attributes(*tables, labels=attributes.labels, material=attributes.material))


def _transform_array(options: argparse.Namespace, matrix: Float64Array) -> None:
    if STDIO not in (options.input, options.output):
        from ...compute.streaming import count_columns

        columns = count_columns(options.input)
        if columns is not None:
            _stream_array(options, _as_3x3(matrix) if columns == 2 else matrix)
            return
    if options.resume:
        raise ArgumentError("--resume needs an .npy file of C-ordered float32 or float64 points, and a file as OUT")
    _transform_whole_array(options, matrix)


def _stream_array(options: argparse.Namespace, matrix: Float64Array) -> None:
    from ..._core import progress
    from ...compute.streaming import transform_file

    device = choose_device(options)
    try:
        with progress.show_progress(options.output, " points", scaled=True) as move:
            transform_file(
                options.input,
                options.output,
                matrix,
                project=options.project,
                resume=options.resume,
                progress=move,
                device=device,
            )
    except KeyboardInterrupt as interrupt:
        interrupt.add_note("the same command with --resume continues")
        raise


def _transform_whole_array(options: argparse.Namespace, matrix: Float64Array) -> None:
    from ...compute._arrays import as_point_array
    from ...compute.transform import project_points, transform_points

    array = files.read_array(options.input)
    try:
        points = as_point_array(array)
    except (ArgumentError, ArgumentTypeError) as error:
        raise ArgumentError(f"{options.input}: {error}") from None
    if points.shape[-1] == 2:
        matrix = _as_3x3(matrix)
    run = project_points if options.project else transform_points
    files.write_array(run(points, matrix, device=choose_device(options)), options.output)


def _as_3x3(matrix: Float64Array) -> Float64Array:
    """Return what a 4x4 matrix does in the xy-plane: (3, 3)."""
    in_plane = [0, 1, 3]
    if matrix[2, in_plane].any():
        raise ArgumentError("the transforms must keep points (n, 2) in the xy-plane, but they move them along z")
    return matrix[np.ix_(in_plane, in_plane)]
