"""Pictures made as planned: drawn, written, compared with their references, and reported on."""

import argparse
import functools
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from .._core.types import Float64Array
from . import exit_codes, files, references
from .argument_types.paths import PAGE_TYPES
from .arguments_from_options import choose_drawing_device, collect_picture_arguments, compose_transforms
from .contact_sheet import SheetOfModels
from .exit_codes import MISMATCH
from .option_errors import name_options_in_errors
from .outcome import Outcome
from .outputs import PlannedPicture
from .read_layers import read_layers
from .reports import RunFacts, embed_images, write_reports
from .stage_times import report_stage
from .streams import print_notice
from .web_pages import make_web_page

if TYPE_CHECKING:
    from ..device import Device
    from ..drawing.layer import Layer

Make = Callable[[Outcome], None]


def collect_page_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """Return the keywords of the page that were typed."""
    names = ("paper", "drawing_scale", "margin", "units")
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


def make_pictures(options: argparse.Namespace, pictures: Sequence[PlannedPicture], unused: Sequence[str]) -> int:
    """Make all pictures that can be made, write the sheet and the reports, and return the exit code.

    Of one picture that nothing is reported of, errors are raised; of others they are printed and reported.

    unused : paths of references that are of no model
    """
    sheet = None
    if options.sheet is not None:
        sheet = SheetOfModels(options, [picture.models[0] for picture in pictures])
    open_device = _keep(lambda: choose_drawing_device(options))  # once for all pictures, when the first is read
    make = functools.partial(_make_picture, options, compose_transforms(options), open_device, sheet)
    for path in unused:
        print_notice(f"warning: {path}: no model has this reference")
    if len(pictures) == 1 and not options.report and sheet is None:
        make(Outcome(pictures[0]))
        return 0
    start = time.perf_counter()
    outcomes = _make_each(pictures, make)
    code = min((outcome.exit_code for outcome in outcomes if outcome.exit_code), default=0)
    if options.report:
        write_reports(options.report, outcomes, RunFacts.of(options, open_device, unused, code, start))
    if sheet is not None:
        sheet.write()
    return code


def _keep(open_device: "Callable[[], Device]") -> "Callable[[], Device]":
    """Return a function that opens a device once, and if that fails, fails alike again."""

    @functools.cache
    def try_once() -> "Device | Exception":
        try:
            return open_device()
        except exit_codes.FAILURES as error:
            return error

    def get() -> "Device":
        found = try_once()
        if isinstance(found, Exception):
            raise found.with_traceback(None)
        return found

    return get


def _make_each(pictures: Sequence[PlannedPicture], make: Make) -> list[Outcome]:
    """Make all pictures that can be made; print the errors of the others, and how many there are of each kind."""
    from .._core import progress

    outcomes = []
    with progress.show_progress("render", " pictures") as move:
        for done, picture in enumerate(pictures, 1):
            outcome = Outcome(picture)
            try:
                make(outcome)
            except exit_codes.FAILURES as error:
                line = exit_codes.format_error(error, picture.name)
                progress.write_line(line.removesuffix("\n"))
                outcome.message = line.removeprefix("gpu-xform: error: ").removeprefix(f"{picture.name}: ").strip()
                outcome.exit_code = exit_codes.exit_code_for(error)
                if outcome.status not in ("differs", "no reference"):
                    outcome.status = "failed"
            if outcome.images:
                outcome.embedded = embed_images(outcome)
                outcome.images.clear()
            outcomes.append(outcome)
            move(done, len(pictures))
    _print_summary(outcomes)
    return outcomes


def _print_summary(outcomes: Sequence[Outcome]) -> None:
    n_mismatched = sum(outcome.exit_code == MISMATCH for outcome in outcomes)
    n_changed = sum(outcome.status in ("added", "updated") for outcome in outcomes)
    n_bad = sum(not outcome.is_good for outcome in outcomes)
    counts = {
        "done": len(outcomes) - n_bad,
        "failed": n_bad - n_mismatched,
        "not matching the reference": n_mismatched,
        f"reference{'s' * (n_changed != 1)} written": n_changed,
    }
    summary = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count or outcome == "done")
    print_notice(f"{len(outcomes)} picture{'s' * (len(outcomes) != 1)}: {summary}")


def _make_picture(
    options: argparse.Namespace,
    world_from_model: Float64Array,
    open_device: "Callable[[], Device]",
    sheet: SheetOfModels | None,
    outcome: Outcome,
) -> None:
    """Draw a picture, write it, and compare it with its reference."""
    start = time.perf_counter()
    picture = outcome.picture
    try:
        if options.keeps_images:
            references.keep_reference(outcome, options)
        layers = read_layers(
            options, picture.models, world_from_model, options.resolution if picture.is_one_of_many else None
        )
        with name_options_in_errors(options, picture.models):
            arguments = _collect_arguments(options, layers, open_device())
            if sheet is not None:
                sheet.add(picture.models[0], layers, arguments)
            if sheet is not None and not (picture.written_paths or picture.reference or options.report):
                outcome.status = "drawn"
                return
            with report_stage(f"drew {picture.output or picture.reference}"):
                drawn = _find_renderer(options, picture.file_type)(layers, **arguments)
        _finish_picture(options, outcome, drawn)
    finally:
        outcome.time_s = time.perf_counter() - start


def _finish_picture(options: argparse.Namespace, outcome: Outcome, drawn: Any) -> None:
    picture = outcome.picture
    _warn_if_blank(drawn, picture)
    if options.keeps_images and picture.file_type in ("png", "svg"):
        outcome.images["picture"] = drawn
    if picture.output is not None:
        files.write_picture(drawn, picture.output, make_folders=options.output.is_per_model)
    outcome.status = "drawn"
    if picture.reference is not None:
        references.compare_with_reference(drawn, outcome, options)


def _warn_if_blank(drawn: Any, picture: PlannedPicture) -> None:
    """Say so if all pixels are alike, as they are if a camera looks past the models."""
    if picture.file_type == "png" and all(low == high for low, high in drawn.getextrema()):
        from .._core import progress

        reason = "the picture is blank: nothing of the models is in view, or all is of the background's colour"
        progress.write_line(f"gpu-xform: warning: {picture.output or picture.reference or picture.name}: {reason}")


def _collect_arguments(options: argparse.Namespace, layers: Sequence["Layer"], device: "Device") -> dict[str, Any]:
    """Return the keywords of all renderers of pictures."""
    arguments = collect_picture_arguments(options, layers, device)
    if options.views is not None:
        arguments |= {"views": options.views, "camera": {"up": options.up}}
        arguments |= {} if options.projection is None else {"projection": options.projection}
    return arguments


def _find_renderer(options: argparse.Namespace, file_type: str) -> Callable[..., Any]:
    if file_type in PAGE_TYPES:
        return functools.partial(make_web_page, options)
    if file_type == "png":
        from ..rendering import raster

        page = collect_page_arguments(options) | ({} if options.dpi is None else {"dpi": options.dpi})
        return functools.partial(raster.render, rasterizer=options.rasterizer, **page)
    from ..rendering import vector

    renderer = {"svg": vector.render_svg, "pdf": vector.render_pdf}[file_type]
    return functools.partial(renderer, **collect_page_arguments(options))
