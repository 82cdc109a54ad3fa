"""Errors of the library, with the files and the options that they are about."""

import contextlib
from argparse import Namespace
from collections.abc import Iterator, Sequence

from .._core.error_context import has_prefix, prefix_error
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from .paths import describe_files

# The options behind arguments of the library that the library alone can check.
OPTIONS_OF_ARGUMENTS = {
    "background": "--no-background",
    "bend": "--bend-stiffness",
    "damping": "--damping",
    "dpi": "--dpi",
    "drag": "--drag",
    "drawing_scale": "--drawing-scale",
    "duration": "--duration",
    "edge_colors": "--edge-colors",
    "edges": "--edges",
    "face_colors": "--face-colors",
    "fill": "--fill",
    "font": "--font",
    "fps": "--fps",
    "friction": "--friction",
    "gap": "--gap",
    "gravity": "--gravity",
    "isolated": "--isolated",
    "labels": "--labels",
    "margin": "--margin",
    "mass": "--mass",
    "drag_rate": "--drag",
    "paper": "--paper",
    "path": "-o",
    "pinned": "--pin",
    "scalars": "--scalars",
    "section": "--section",
    "hatch": "--hatch",
    "shear": "--shear-stiffness",
    "size": "--resolution",
    "stretch": "--stretch-stiffness",
    "substeps": "--substeps",
    "wind": "--wind",
    "units": "--units",
    "vertex_colors": "--vertex-colors",
}
# Those that together need more steps than there may be: named as far as they were given.
MATERIAL = ("--stretch-stiffness", "--shear-stiffness", "--bend-stiffness", "--mass")
# Options that fit the models, or do not.
_OF_MODELS = ("--paper", "--resolution", "--section", "--stretch-stiffness")


@contextlib.contextmanager
def name_options_in_errors(options: Namespace, paths: Sequence[str]) -> Iterator[None]:
    """Prefix errors about models with the names of their files, and errors about arguments with the options.

    An argument that no option gives was made of the models. With --layer, errors name their model already.

    paths : of the models; none before they are read, and for samples
    """
    extra = [model for layer in options.extra_layers for model in layer.models] if options.extra_layers else []
    subject = describe_files([*paths, *extra]) if paths else ""
    try:
        yield
    except MeshError as error:
        if options.extra_layers or not paths or any(has_prefix(error, path) for path in paths):
            raise
        raise prefix_error(error, describe_files(paths)) from error.__cause__
    except (ArgumentError, ArgumentTypeError) as error:
        flag = OPTIONS_OF_ARGUMENTS.get(error.argument or "")
        if error.argument == "max_substeps":
            flag = ", ".join(name for name in MATERIAL if getattr(options, name[2:].replace("-", "_")) is not None)
        named = prefix_error(error, flag) if flag and not has_prefix(error, flag) else error
        if subject and error.argument is not None and (not flag or flag in _OF_MODELS):
            named = prefix_error(named, subject)
        raise named from error.__cause__
