"""`gpu-xform transform`: model files and arrays of points, transformed or converted."""

import argparse
import contextlib
import os
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..._core.error_context import prefix_error
from ..._core.types import Float64Array
from ...errors import ArgumentError, ArgumentTypeError, MeshError, MeshWarning
from ...geometry.attributes import Attributes
from ...geometry.mesh import Mesh, move
from .. import exit_codes, files
from .. import options as groups
from ..argument_types import numbers, paths, vectors
from ..arguments_from_options import choose_device, compose_transforms
from ..path_templates import BRACES, PLACEHOLDERS
from ..paths import STDIO, expand_globs, file_type, is_stream, require_target, require_type
from ..reading_options import require_no_reading_options
from ..stage_times import report_stage
from ..streams import name_file_in_errors, print_notice, raise_warnings

# The options behind arguments of `transform_file`.
SCAN_OPTIONS = {
    "offset": "--las-offset",
    "resume": "--resume",
    "scale": "--las-scale",
    "scheduler": "--scheduler",
    "workers": "--workers",
}
AFFINE_LAST_ROW = (0.0, 0.0, 0.0, 1.0)
MAX_UNUSED = 8  # names of a table that are told

USAGE = "IN... OUT [options]"
DESCRIPTION = """\
Transform the points of models, whose polygons and attributes stay, of arrays,
or of scans of any size. Models and scans are transformed in double precision,
arrays in their own. What OUT cannot hold is named on standard error."""
EPILOG = """\
IN and OUT are model files, of the same or of different types; an .npy file of
points (n, 3) is one of them. From .npy to .npy, the points may also be (n, 2).
Without transforms, the file is converted.

Points of any size go from .las, .laz, .copc.laz, .zarr, .npy and .ply (binary,
without faces) to .las, .laz and .zarr, from .las, .laz and .zarr to .npy and
.ply as well, and from .npy to .npy and .ply to .ply; .las and .laz that fit in
memory to model files as well. LAS needs the extra las, Zarr the extra zarr,
several processes the extra dask: pip install 'gpu_xform[las]'.

An interrupted run leaves its results beside OUT, in OUT.partial and
OUT.partial.work, and --resume continues from there. Without them it begins,
unless OUT is MODEL itself: a run that ended has moved its points already.

If there are several inputs, OUT holds {model}, which stands for the name of
each without folder and type, {suffix} for its type, {parent} for the name of
its folder, or {folder} for the path of that; missing folders are made. If one
of them fails, the others are still made.

A --matrix-table is JSON ({"tile.laz": [16 numbers, row by row], ...}, a list,
or a pose graph or camera trajectory of Open3D), CSV (a name and 16 numbers, 12,
or 8: scale, quaternion w,x,y,z and translation, or titles such as qw and tx in
any order, or a name and the file of a matrix as CloudCompare writes it), a text
of such matrices, one below the other, or COLMAP's images.txt. Names count with
folder and type, or without. Poses of cameras are inverted, so that they lead
into the world. Its matrices apply first.

examples:
  gpu-xform transform in.obj out.ply --scale 0.3 --translate -0.5,2,0
  gpu-xform transform cloud.npy cloud.npy --matrix pose.txt
  gpu-xform transform cube.off flat.off --perspective-from-eye 5 --project
  gpu-xform transform tile.laz moved.laz --matrix pose.txt
  gpu-xform transform tiles/*.laz "moved/{model}.laz" --matrix-table poses.json
  gpu-xform transform big.zarr moved.zarr --rotate-z 30 --workers 4
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `transform`."""
    group = parser.add_argument_group("files")
    group.add_argument(
        "inputs",
        metavar="IN",
        nargs="+",
        type=paths.parse_points_path,
        help="a model file, an .npy file, a scan, or a pattern such as *.laz; - for standard input",
    )
    group.add_argument(
        "output",
        metavar="OUT",
        type=paths.parse_points_path,
        help="the result, with {model} in it if there are several; - for standard output, in the type of IN",
    )
    groups.add_reading_options(group)
    groups.add_pose(group)
    group.add_argument(
        "--strict", action="store_true", help="fail, and write nothing, if the result cannot hold all that IN holds"
    )
    _add_scan_options(parser)
    transforms = groups.add_transforms(parser)
    transforms.add_argument(
        "--matrix-table",
        metavar="FILE",
        help="a matrix per input, which applies first: a .json, .csv or images.txt file",
    )
    transforms.add_argument("--project", action="store_true", help="divide by w, which perspective needs")
    groups.add_general_options(parser, adapter=True)


def _add_scan_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("points of any size")
    group.add_argument("--resume", action="store_true", help="continue an interrupted run")
    group.add_argument(
        "--skip-bad-chunks",
        action="store_true",
        help="leave chunks that cannot be decompressed as they were, from .laz to .laz and from .zarr to .zarr",
    )
    group.add_argument(
        "--las-scale",
        metavar="S|X,Y,Z",
        type=numbers.parse_grid_scale,
        help="unit of the coordinates of a .las or .laz file (default: that of IN, wider where 32 bits need it)",
    )
    group.add_argument(
        "--las-offset",
        metavar="X,Y,Z",
        type=vectors.parse_point,
        help="offset of the coordinates of a .las or .laz file (default: the centre of the result)",
    )
    group.add_argument("--keep-normals", action="store_true", help="leave normals and vectors of waveforms as they are")
    group.add_argument("--workers", metavar="N", type=numbers.parse_workers, help="run N processes on this machine")
    group.add_argument(
        "--scheduler", metavar="ADDRESS", help="use the workers of a running Dask scheduler, such as tcp://host:8786"
    )


def run(options: argparse.Namespace) -> int:
    """Transform or convert model files, arrays or scans."""
    inputs = expand_globs(options.inputs)
    tasks = _plan_tasks(options, inputs)
    if len(tasks) == 1:
        try:
            _transform(tasks[0])
        except MeshError as error:  # of what the target cannot hold as well
            raise (error if _names(error, tasks[0].input) else prefix_error(error, tasks[0].input)) from None
        return 0
    from ..._core import progress

    codes = []
    with progress.show_progress("transform", " files") as move:
        for done, task in enumerate(tasks, 1):
            try:
                _transform(task)
            except exit_codes.FAILURES as error:
                subject = "" if _names(error, task.input) else task.input
                progress.write_line(exit_codes.format_error(error, subject).removesuffix("\n"))
                codes.append(exit_codes.exit_code_for(error))
            move(done, len(tasks))
    if tasks[0].table is not None and (unused := tasks[0].table.unused):
        more = f", and {len(unused) - MAX_UNUSED} more" if len(unused) > MAX_UNUSED else ""
        print_notice(f"{options.matrix_table}: no input for {', '.join(unused[:MAX_UNUSED])}{more}")
    failed = f", {len(codes)} failed" if codes else ""
    print_notice(f"{len(tasks)} files: {len(tasks) - len(codes)} done{failed}")
    return min(codes, default=0)


def _names(error: Exception, path: str) -> bool:
    """Return whether an error begins with the path of a file, or what became of it."""
    return str(error).startswith((f"{path}: ", f"{path}, transformed: "))


def _plan_tasks(options: argparse.Namespace, inputs: Sequence[str]) -> list[argparse.Namespace]:
    """Return the options for each input, with its `input`, `output` and `place`; raise for paths written twice."""
    is_template = any(placeholder in options.output for placeholder in PLACEHOLDERS)
    is_template |= any(braces[1:-1].isidentifier() for braces in BRACES.findall(options.output))  # which is refused
    if len(inputs) > 1 and not is_template:
        raise ArgumentError(f"{options.output}: {len(inputs)} files need a path with {{model}} in it")
    table = None
    if options.matrix_table is not None:
        from ..matrix_table import MatrixTable

        table = MatrixTable(options.matrix_table)
    try:
        template = paths.parse_template(options.output) if is_template else None
    except argparse.ArgumentTypeError as error:
        raise ArgumentError(str(error)) from None
    tasks, owners = [], dict[str, str]()
    sources = {os.path.normcase(os.path.realpath(path)): path for path in inputs if path != STDIO}
    for place, path in enumerate(inputs):
        output = template.path_for(path) if template is not None else options.output
        location = os.path.normcase(os.path.realpath(output))
        if location in owners:
            raise ArgumentError(f"{output}: two results would be written there, of {owners[location]} and of {path}")
        owners[location] = path
        if sources.get(location, path) != path:
            raise ArgumentError(f"{output}: the result of {path} would replace {sources[location]}, another input")
        changes = {"input": path, "output": output, "place": place, "count": len(inputs), "table": table}
        tasks.append(argparse.Namespace(**{**vars(options), **changes, "make_folders": template is not None}))
    return tasks


def _transform(options: argparse.Namespace) -> None:
    """Transform or convert one input."""
    source = file_type(options.input, options.file_type)
    target = source if options.output == STDIO else file_type(options.output)
    if target != "zarr":
        require_target(options.output)
    matrix = compose_transforms(options)
    if options.table is not None:
        found = options.table.find(options.input, options.place, options.count)
        if not options.project and found[3, :3].any() and not found[:3, 3].any():
            raise ArgumentError(
                f"{options.matrix_table}: the matrix of {options.input} ends in the row {found[3].tolist()}: it seems "
                f"to be stored column by column, and must be row by row"
            )
        matrix = matrix @ found
    if not options.project and tuple(matrix[3]) != AFFINE_LAST_ROW:
        raise ArgumentError("the transforms are projective: give --project to divide the points by w")
    if options.make_folders:
        Path(options.output).parent.mkdir(parents=True, exist_ok=True)
    with raise_warnings() if options.strict else contextlib.nullcontext():
        if source == target == "npy":
            _transform_array(options, matrix)
        elif _is_scan(options.input, source, target):
            _transform_scan(options, matrix, source, target)
        else:
            _require_no_scan_options(options)
            from ...formats.registry import WRITERS

            require_type(options.output, tuple(sorted({*WRITERS, *SCAN_TYPES})), target)
            _transform_mesh(options, matrix, target)


SCAN_TYPES = ("las", "laz", "zarr")


def _is_scan(path: str, source: str, target: str) -> bool:
    """Return whether an input goes through a part at a time."""
    from ...chunked.ply import is_cloud
    from ...chunked.registry import CHUNKED_TYPES

    if target in SCAN_TYPES or (source in SCAN_TYPES and (target in CHUNKED_TYPES or source == "zarr")):
        return True

    return source == target == "ply" and not is_stream(path) and is_cloud(path)


def _transform_scan(options: argparse.Namespace, matrix: Float64Array, source: str, target: str) -> None:
    from ...chunked.registry import CHUNKED_TYPES

    if STDIO in (options.input, options.output):
        if source == target == "ply":
            _transform_mesh(options, matrix, target)
            return
        raise ArgumentError(f"{options.input}: .las, .laz and .zarr go from a file to a file, not through a pipe")
    require_type(options.input, CHUNKED_TYPES, options.file_type)
    require_type(options.output, CHUNKED_TYPES)
    if file_type(options.input) != source:
        raise ArgumentError(f"{options.input}: scans are known by the end of their name: .{source}, not --file-type")
    _stream(options, matrix)


def _require_no_scan_options(options: argparse.Namespace) -> None:
    if options.resume:
        raise ArgumentError("--resume is for .npy files that become .npy files, and for .las, .laz, .zarr, .ply scans")
    for name in ("skip_bad_chunks", "las_scale", "las_offset", "keep_normals", "workers", "scheduler"):
        if getattr(options, name):
            raise ArgumentError(
                f"--{name.replace('_', '-')} is for scans: .las, .laz, .zarr, and binary .ply without faces"
            )


def _transform_mesh(options: argparse.Namespace, matrix: Float64Array, target: str) -> None:
    from ...compute.transform import project_points, transform_points
    from ...formats.registry import DOCUMENT_TYPES, transform_document

    source = file_type(options.input, options.file_type)
    if {source, target} <= set(DOCUMENT_TYPES) and not options.project and options.pose is None:
        limits = options.file_limits
        if options.isolated or (limits is not None and (limits.cpu_s or limits.memory_bytes)):
            flag = "--isolated" if options.isolated else "--file-limits of cpu_s and memory_bytes"
            raise ArgumentError(
                f"{options.input}: {flag} is for meshes, and glTF that becomes glTF is copied with all that it holds"
            )
        with name_file_in_errors(options.output):
            transform_document(
                files.open_source(options.input),
                files.open_target(options.output),
                matrix,
                source_type=source,
                target_type=target,
            )
        return
    mesh = files.read_mesh(options.input, options.file_type, options.tolerance, options.pose)
    run = project_points if options.project else transform_points
    device = choose_device(options)
    with report_stage("transformed"):
        positions = run(mesh.positions, matrix, device=device)
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
    if not is_stream(options.input) and options.output != STDIO:
        from ...compute.streaming import count_columns

        columns = count_columns(options.input)
        if columns is not None:
            _stream(options, _as_3x3(matrix) if columns == 2 else matrix)
            return
    if options.resume:
        raise ArgumentError("--resume needs an .npy file of C-ordered float32 or float64 points, and a file as OUT")
    _require_no_scan_options(options)
    _transform_whole_array(options, matrix)


def _stream(options: argparse.Namespace, matrix: Float64Array) -> None:
    from ..._core import progress
    from ...compute.streaming import count_columns, transform_file

    require_no_reading_options(options, options.input)
    has_workers = options.workers is not None or options.scheduler is not None
    if has_workers and options.adapter is not None:
        raise ArgumentError("--adapter is for one process; workers have a device each")
    if file_type(options.input) == "zarr" and len(matrix) == 4:
        from ...chunked.zarr import ZarrSource

        matrix = _as_3x3(matrix) if ZarrSource(options.input).n_columns == 2 else matrix
    if file_type(options.input) == "npy" and len(matrix) == 4 and count_columns(options.input) == 2:
        matrix = _as_3x3(matrix)
    device = None if has_workers else choose_device(options)
    try:
        label = f"read {options.input}, transformed, wrote {options.output}"
        with report_stage(label), progress.show_progress(options.output, " points", scaled=True) as move:
            transform_file(
                options.input,
                options.output,
                matrix,
                project=options.project,
                scale=options.las_scale,
                offset=options.las_offset,
                normals="keep" if options.keep_normals else "auto",
                resume=options.resume,
                skip_bad_chunks=options.skip_bad_chunks,
                workers=options.workers,
                scheduler=options.scheduler,
                progress=move,
                device=device,
            )
    except (ArgumentError, ArgumentTypeError) as error:
        flag = SCAN_OPTIONS.get(error.argument or "")
        raise (prefix_error(error, flag) if flag else error) from error.__cause__
    except (KeyboardInterrupt, OSError) as error:
        if Path(os.path.realpath(options.output) + ".partial.work").exists():
            error.add_note("the same command with --resume continues")
        raise


def _transform_whole_array(options: argparse.Namespace, matrix: Float64Array) -> None:
    from ...compute._arrays import as_point_array
    from ...compute.transform import project_points, transform_points

    require_no_reading_options(options, options.input)
    array = files.read_array(options.input)
    try:
        points = as_point_array(array)
    except (ArgumentError, ArgumentTypeError) as error:
        raise ArgumentError(f"{options.input}: {error}") from None
    if points.shape[-1] == 2:
        matrix = _as_3x3(matrix)
    run = project_points if options.project else transform_points
    device = choose_device(options)
    with report_stage("transformed"):
        moved = run(points, matrix, device=device)
    files.write_array(moved, options.output)


def _as_3x3(matrix: Float64Array) -> Float64Array:
    """Return what a 4x4 matrix does in the xy-plane: (3, 3)."""
    in_plane = [0, 1, 3]
    if matrix[2, in_plane].any():
        raise ArgumentError("the transforms must keep points (n, 2) in the xy-plane, but they move them along z")
    return matrix[np.ix_(in_plane, in_plane)]
