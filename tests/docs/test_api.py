"""The page that lists all names lists those there are."""

import re
from pathlib import Path

import numpy as np

import gpu_xform
from gpu_xform import errors
from gpu_xform.geometry.joints import Joint
from gpu_xform.gpu.device import GpuDevice

PAGE, RETURNED = (
    (Path(__file__).parents[2] / "docs" / "api.md").read_text("utf-8").split("\n## What functions return\n")
)
ROWS = re.findall(r"^\| `(\w+)` +\| (.+?) +\|$", PAGE, re.MULTILINE)


def test_the_page_names_exactly_the_public_names() -> None:
    names = [name for name, _ in ROWS]
    assert sorted(names) == gpu_xform.__all__
    assert len(names) == PAGE.count("\n| `")


def test_the_page_says_what_an_error_is_besides() -> None:
    for name, phrase in ROWS:
        value = getattr(gpu_xform, name)
        if value is errors.GpuXformError or not isinstance(value, type) or not issubclass(value, errors.GpuXformError):
            continue
        public = {base.__name__ for base in value.__bases__ if not base.__name__.startswith("_")}
        others = public - {"GpuXformError"}
        assert set(re.findall(r"`(\w+)`", phrase)) == others, name


def test_the_page_says_all_that_returned_values_hold(device: GpuDevice) -> None:
    picture = np.zeros((2, 2, 4), np.uint8)
    springs = gpu_xform.Springs([[0, 0, 0]], mass=1.0, device=device)
    values = [
        gpu_xform.decompose(np.eye(4)),
        gpu_xform.Scene().add(name="node"),
        gpu_xform.compare_images(picture, picture),
        Joint("elbow", "revolute", "hand", np.eye(4), np.array([0.0, 0.0, 1.0])),
        springs.energy(),
        springs.momentum(),
        device.adapter,
        device.limits,
    ]
    rows = re.findall(r"^\| `(\w+)` +\| (.+?) +\| (.+?) \|$", RETURNED, re.MULTILINE)
    assert len(rows) == RETURNED.count("\n| `")
    held = {type(value).__name__: {name for name in dir(value) if name[0] != "_"} for value in values}
    for name in ("Decomposition", "Energy", "Momentum"):
        held[name] -= set(dir(tuple))
    assert {name: set(re.findall(r"`(\w+)(?:\(\))?`", phrase)) for name, _, phrase in rows} == held
