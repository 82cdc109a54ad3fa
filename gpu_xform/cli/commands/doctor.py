"""`gpu-xform doctor`: a report on the graphics adapters."""

import argparse
import json

from .. import options as groups
from ..exit_codes import DEVICE_FAILED, NO_ADAPTER
from ..streams import print_notice, print_stdout

USAGE = "[options]"
DESCRIPTION = "List the graphics adapters, and check that the results of one are right."
EPILOG = f"""\
exit codes:
  0  all checks passed
  {DEVICE_FAILED}  a check failed
  {NO_ADAPTER}  no graphics adapter; the report says what to install
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `doctor`."""
    groups.add_json(parser, "report")
    parser.add_argument(
        "--tune",
        action="store_true",
        help="time both rasterisers over numbers of edges and their lengths, and let later pictures on this GPU take "
        "the faster one; kept in the user's cache folder, or in $GPU_XFORM_TUNING",
    )
    groups.add_general_options(parser, adapter=True)


def run(options: argparse.Namespace) -> int:
    """Report on the adapters, or time the rasterisers of one."""
    if options.tune:
        return _tune(options)
    from ...diagnostics.doctor import examine

    report = examine(options.adapter)
    print_stdout(report.json() if options.json else report.text())
    if report.passed:
        return 0
    return NO_ADAPTER if report.device is None else DEVICE_FAILED


def _tune(options: argparse.Namespace) -> int:
    """Time the rasterisers, and keep what was measured."""
    from ...diagnostics.tune import format_tuning, tune
    from ...gpu.device import GpuDevice
    from ...raster.tuning import save_tuning

    with GpuDevice(options.adapter) as device:
        cells = tune(device)
        if options.json:
            fields = {"adapter": device.name, "driver": device.adapter.driver, "cells": [c._asdict() for c in cells]}
            print_stdout(json.dumps(fields, indent=2) + "\n")
        else:
            print_stdout(format_tuning(device, cells))
        try:
            path = save_tuning(device.adapter, cells)
        except OSError as error:
            print_notice(f"warning: the tuning could not be kept: {error}")
        else:
            if not options.json:
                print_stdout(f"Kept in {path}\n")
    return 0
