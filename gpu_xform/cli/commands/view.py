"""`gpu-xform view`: models in a window."""

import argparse

from ...viewer.key_bindings import HELP
from .. import camera_options as aim
from .. import files
from .. import options as option_groups
from ..read_layers import naming, read_layers, require_scalars
from .transform import chosen_device, composed

SUMMARY = "show models in a window, to turn and to look at closely"
USAGE = "MODEL... [options]"
DESCRIPTION = """\
Show models, transformed, in a window. It needs a display, and rendercanvas and
GLFW: pip install 'gpu_xform[viewer]'."""
IN_THE_WINDOW = "".join(f"  {key:<19}{what}\n" for key, what in HELP)
EPILOG = f"""\
in the window:
{IN_THE_WINDOW}
examples:
  gpu-xform view ball.wrl --color face
  gpu-xform view part.stl --up +Z --edges feature,silhouette --hidden dash
  gpu-xform view house.obj garden.ply --resolution 1280x960 --fill gold
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `view` to its parser."""
    group = parser.add_argument_group("files")
    option_groups.add_models(group)
    option_groups.add_file_type(group)
    option_groups.add_transforms(parser)
    option_groups.add_picture(parser)
    parser.set_defaults(resolution="960,720")
    option_groups.add_style(parser)
    option_groups.add_camera(parser)
    option_groups.add_rest(parser, adapter=True)


def view(options: argparse.Namespace) -> int:
    """Show models until the window is closed."""
    aim.require_one_aim(options)
    require_scalars(options)
    from ...viewer.window import view

    paths = files.matching(options.models)
    shown = read_layers(options, paths, composed(options))
    with naming(options, paths):
        view(
            shown,
            camera=aim.camera(options, shown),
            up=options.up if options.camera_view_up is None else None,
            size=options.resolution,
            background=options.background,
            device=chosen_device(options),
        )
    return 0
