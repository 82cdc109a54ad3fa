"""The commands: from parsed options to the library and back to files."""

import json
import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ... import matrices
from ..._core import progress
from ..._core.types import Float64Array
from ...errors import ArgumentError, ArgumentTypeError, MeshError
from ...geometry.mesh import Mesh
from .. import files
from ..exit_codes import DEVICE_FAILED, NO_ADAPTER

if TYPE_CHECKING:
    from ...gpu.device import Device

AFFINE_ROW = (0.0, 0.0, 0.0, 1.0)


def transform(options: Namespace) -> int:
    """Transform a model file or an array, or make one of the other."""
    source = files.kind(options.input, options.file_type)
    target = source if options.output == files.STANDARD else files.kind(options.output)
    matrix = composed(options)
    if not options.project and tuple(matrix[3]) != AFFINE_ROW:
        raise ArgumentError("the transforms are projective: with --project, points are divided by w")
    if source == target == "npy":
        _transform_array(options, matrix)
    else:
        if options.resume:
            raise ArgumentError("--resume is for .npy files that become .npy files")
        from ...formats.registry import WRITERS

        files.require_type(options.output, tuple(sorted(WRITERS)), target)
        _transform_mesh(options, matrix, target)
    return 0


def explain(options: Namespace) -> int:
    """Print matrices."""
    if not options.steps:
        raise ArgumentError("explain needs a transform, such as --rotate-z 90")
    files.say(matrices.explain(*options.steps, point=options.point) + "\n")
    return 0


def doctor(options: Namespace) -> int:
    """Report on the adapters."""
    from ...diagnostics.doctor import examine

    report = examine(options.adapter)
    files.say(report.json() if options.json else report.text())
    if report.passed:
        return 0
    return NO_ADAPTER if report.device is None else DEVICE_FAILED


def bench(options: Namespace) -> int:
    """Time bulk transforms."""
    from ...diagnostics.bench import measure, report
    from ...gpu.device import Device

    device = Device(options.adapter)
    timings = []
    with progress.bar("bench", " sizes") as move:
        for done, n_points in enumerate(options.points, 1):
            timings.append(measure(device, n_points, options.dtype))
            move(done, len(options.points))
    if options.json:
        facts = {"adapter": device.name, "kind": device.adapter.kind, "driver": device.adapter.driver}
        files.say(
            json.dumps(facts | {"dtype": options.dtype, "sizes": [t.as_dict() for t in timings]}, indent=2) + "\n"
        )
    else:
        files.say(report(device, options.dtype, timings))
    return 0


def _transform_mesh(options: Namespace, matrix: Float64Array, target: str) -> None:
    from ...compute.transform import project_points, transform_points

    mesh = files.read_mesh(options.input, options.file_type)
    run = project_points if options.project else transform_points
    positions = run(mesh.positions, matrix, device=chosen_device(options))
    try:
        moved = Mesh.from_offsets(positions, mesh.offsets, mesh.indices)
    except MeshError as error:  # a coordinate that has overflowed, or was divided by w = 0
        raise MeshError(f"{options.input}, transformed: {error}") from None
    files.write_mesh(moved, options.output, target)


def _transform_array(options: Namespace, matrix: Float64Array) -> None:
    if files.STANDARD not in (options.input, options.output) and not _is_special(options.output):
        from ...compute.streaming import n_columns

        columns = n_columns(options.input)
        if columns is not None:
            _stream_array(options, _planar(matrix) if columns == 2 else matrix)
            return
    if options.resume:
        raise ArgumentError("--resume goes from an .npy file of float32 or float64 points, C-ordered, to a file")
    _transform_whole_array(options, matrix)


def _stream_array(options: Namespace, matrix: Float64Array) -> None:
    from ...compute.streaming import transform_file

    device = chosen_device(options)
    try:
        with progress.bar(options.output, " points", scaled=True) as move:
            transform_file(
                options.input,
                options.output,
                matrix,
                project=options.project,
                resume=options.resume,
                progress=move,
                device=device,
            )
    except KeyboardInterrupt:
        sys.stderr.write("gpu-xform: interrupted; the same command with --resume goes on\n")
        raise


def _is_special(path: str) -> bool:
    return Path(path).exists() and not Path(path).is_file()


def _transform_whole_array(options: Namespace, matrix: Float64Array) -> None:
    from ...compute._arrays import as_point_array
    from ...compute.transform import project_points, transform_points

    array = files.read_array(options.input)
    try:
        points = as_point_array(array)
    except (ArgumentError, ArgumentTypeError) as error:
        raise ArgumentError(f"{options.input}: {error}") from None
    if points.shape[-1] == 2:
        matrix = _planar(matrix)
    run = project_points if options.project else transform_points
    files.write_array(run(points, matrix, device=chosen_device(options)), options.output)


def _planar(matrix: Float64Array) -> Float64Array:
    """Return what a 4x4 matrix does to the xy-plane: (3, 3)."""
    in_plane = [0, 1, 3]
    if matrix[2, in_plane].any():
        raise ArgumentError("the transforms must keep points (n, 2) in the xy-plane, but they move them along z")
    return matrix[np.ix_(in_plane, in_plane)]


def composed(options: Namespace) -> Float64Array:
    """Return the matrix (4, 4) of the transforms typed."""
    return matrices.chain(matrices.identity(), *options.steps)


def chosen_device(options: Namespace) -> "Device":
    """Return the device of --adapter, the default one without."""
    from ...gpu.device import Device, default_device

    return default_device() if options.adapter is None else Device(options.adapter)
