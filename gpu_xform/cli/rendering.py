"""`gpu-xform render`: from model files to pictures, and from pictures to a verdict."""

import functools
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import progress
from .._arguments import Float64Array
from ..errors import MeshError
from ..mesh import Mesh
from . import aim, failures, files, option_groups, references
from .commands import chosen_device, composed
from .pictures import Picture, planned

if TYPE_CHECKING:
    from PIL.Image import Image

    from ..gpu.device import Device


def render(options: Namespace) -> int:
    """Draw models, all into one picture or each into its own, and compare what was drawn with references."""
    aim.require_one_aim(options)
    references.require_options_together(options)
    models = [path for typed in options.models for path in files.matching(typed)]
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
    image = _drawn(options, world_from_model, device, picture)
    if picture.output is not None:
        files.write_picture(image, picture.output, make_folders=options.output.one_for_each)
    if picture.reference is not None:
        references.require_like(picture.reference, image, picture.difference, options)


def _drawn(options: Namespace, world_from_model: Float64Array, device: "Device", picture: Picture) -> "Image":
    from .. import wireframe
    from ..subjects import world_positions

    mesh = _together([files.read_mesh(path, options.file_type) for path in picture.models])
    try:
        return wireframe.render(
            mesh,
            transform=world_from_model,
            camera=aim.camera(options, world_positions(mesh.positions, world_from_model)),
            size=options.resolution,
            background=options.background,
            device=device,
            **option_groups.style(options),
        )
    except MeshError as error:
        raise MeshError(f"{picture.name}: {error}") from None


def _together(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of several: their points and their faces, one mesh after the other."""
    if len(meshes) == 1:
        return meshes[0]
    before = np.cumsum([0, *(mesh.n_points for mesh in meshes[:-1])])
    indices = [mesh.indices + first for mesh, first in zip(meshes, before, strict=True)]
    sizes = np.concatenate([np.diff(mesh.offsets) for mesh in meshes])
    return Mesh.from_offsets(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([[0], np.cumsum(sizes)]),
        np.concatenate(indices),
    )
