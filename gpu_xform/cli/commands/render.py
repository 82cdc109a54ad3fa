"""`gpu-xform render`: from model files to pictures, and from pictures to a verdict."""

import functools
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..._core import progress
from ..._core.types import Float64Array
from .. import camera_options as aim
from .. import exit_codes as failures
from .. import files, references
from ..outputs import Picture, planned
from ..read_layers import naming, read_layers, require_scalars
from .transform import chosen_device, composed

if TYPE_CHECKING:
    from ...gpu.device import Device


def render(options: Namespace) -> int:
    """Draw models, all into one picture or each into its own, and compare what was drawn with references."""
    aim.require_one_aim(options)
    require_scalars(options)
    references.require_options_together(options)
    models = files.matching(options.models)
    pictures = planned(models, options.output, options.reference, options.reference_diff)
    finish = functools.partial(_finish, options, composed(options), chosen_device(options))
    if len(pictures) > 1:
        return _finish_each(pictures, finish)
    finish(pictures[0])
    return 0


def _finish_each(pictures: Sequence[Picture], finish: Callable[[Picture], None]) -> int:
    """Finish every picture that can be; say what is wrong with the others, and how many there are of each."""
    codes = []
    with progress.bar("render", " pictures") as move:
        for done, picture in enumerate(pictures, 1):
            try:
                finish(picture)
            except failures.FAILURES as error:
                progress.write(failures.line(error, picture.name))
                codes.append(failures.exit_code(error))
            move(done, len(pictures))
    different = codes.count(failures.DIFFERENT)
    counts = {"done": len(pictures) - len(codes), "failed": len(codes) - different, "not as the reference": different}
    said = ", ".join(f"{count} {what}" for what, count in counts.items() if count or what == "done")
    sys.stderr.write(f"gpu-xform: {len(pictures)} pictures: {said}\n")
    return min(codes, default=0)


def _finish(options: Namespace, world_from_model: Float64Array, device: "Device", picture: Picture) -> None:
    """Draw a picture, write it, and compare it with its reference."""
    drawn = _drawn(options, world_from_model, device, picture)
    if picture.output is not None:
        files.write_picture(drawn, picture.output, make_folders=options.output.one_for_each)
    if picture.reference is not None:
        references.require_like(picture.reference, drawn, picture.difference, options)


def _drawn(options: Namespace, world_from_model: Float64Array, device: "Device", picture: Picture) -> Any:
    """Return a Pillow image, the text of an SVG, or the bytes of a PDF."""
    shown = read_layers(options, picture.models, world_from_model)
    with naming(options, picture.models):
        return _renderer(picture.kind)(
            shown,
            camera=aim.camera(options, shown),
            size=options.resolution,
            background=options.background,
            device=device,
        )


def _renderer(kind: str) -> Callable[..., Any]:
    if kind == "png":
        from ...rendering import raster as wireframe

        return wireframe.render
    from ...rendering import vector as vector_pictures

    return {"svg": vector_pictures.render_svg, "pdf": vector_pictures.render_pdf}[kind]
