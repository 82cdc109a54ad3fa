"""`gpu-xform view`: models in an interactive window."""

import argparse

from ...viewer.key_bindings import HELP
from .. import options as groups
from ..arguments_from_options import (
    choose_drawing_device,
    collect_picture_arguments,
    compose_transforms,
    require_drawing_options,
)
from ..layer_option import parse_layer
from ..option_errors import name_options_in_errors
from ..paths import expand_globs
from ..read_layers import read_layers

KEYS = "".join(f"  {key:<19}{effect}\n" for key, effect in HELP)

USAGE = "MODEL... [options]"
DESCRIPTION = """\
Show models, transformed, in an interactive window. This needs a display, and
rendercanvas and GLFW: pip install 'gpu_xform[viewer]'."""
EPILOG = f"""\
in the window:
{KEYS}
examples:
  gpu-xform view ball.wrl --color face
  gpu-xform view part.stl --up +Z --edges feature,silhouette --hidden dash
  gpu-xform view house.obj garden.ply --resolution 1280x960 --fill gold
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `view`."""
    group = parser.add_argument_group("files")
    groups.add_models(group, parse_layer)
    groups.add_reading_options(group)
    groups.add_pose(group)
    groups.add_parts(group)
    groups.add_drawing_options(parser, resolution="960,720")
    groups.add_general_options(parser, adapter=True, rasterizer=True)


def run(options: argparse.Namespace) -> int:
    """Show models until the window is closed."""
    require_drawing_options(options)
    from ...viewer.window import view

    paths = expand_globs(options.models)
    layers = read_layers(options, paths, compose_transforms(options))
    with name_options_in_errors(options, paths):
        view(
            layers,
            up=options.up if options.camera_view_up is None else None,
            rasterizer=options.rasterizer,
            **collect_picture_arguments(options, layers, choose_drawing_device(options)),
        )
    return 0
