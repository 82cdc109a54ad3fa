"""`gpu-xform doctor`: a report on the graphics adapters."""

import argparse

from .. import options as groups
from ..exit_codes import DEVICE_FAILED, NO_ADAPTER
from ..streams import print_stdout

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
    groups.add_general_options(parser, adapter=True)


def run(options: argparse.Namespace) -> int:
    """Report on the adapters."""
    from ...diagnostics.doctor import examine

    report = examine(options.adapter)
    print_stdout(report.json() if options.json else report.text())
    if report.passed:
        return 0
    return NO_ADAPTER if report.device is None else DEVICE_FAILED
