"""Markers that follow from the fixtures of a test."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

MARKING_FIXTURES = ("browser", "screen")
TESTS = Path(__file__).parents[1]
# Tests whose parameters say what an adapter computes with; those of `gpu` read texts unless they ask for a device.
COMPUTING = TESTS / "compute"
COMPILING = {TESTS / "gpu" / "test_layouts.py", TESTS / "gpu" / "test_wgsl.py"}


def mark_by_fixtures(items: Iterable[pytest.Item]) -> None:
    """Give every test that uses a fixture in `MARKING_FIXTURES`, itself or through others, the marker of that name."""
    for item in items:
        for fixture in MARKING_FIXTURES:
            if fixture in getattr(item, "fixturenames", ()):
                item.add_marker(fixture)


def mark_by_dtypes(items: Iterable[pytest.Item]) -> None:
    """Give every test of computations that has float64 among its parameters the marker `float64`; not on the host."""
    for item in items:
        parameters = params_of(item)
        is_double = any(map(is_float64, parameters.values())) and parameters.get("process_device") != "host"
        compiles = item.path in COMPILING and "device" in getattr(item, "fixturenames", ())
        if is_double and (compiles or COMPUTING in item.path.parents):
            item.add_marker("float64")


def params_of(item: pytest.Item) -> dict[str, Any]:
    """Return the parameters of a test."""
    return getattr(getattr(item, "callspec", None), "params", {})


def is_float64(value: Any) -> bool:
    """Tell whether a parameter is the type of double precision."""
    return value is np.float64 or (isinstance(value, str) and value in ("float64", "f64", "real_f64", ">f8", "<f8"))
