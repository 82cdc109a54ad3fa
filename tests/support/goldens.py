"""Golden pictures, kept beside the tests, and their comparison with the pictures drawn now.

    pytest tests/raster/test_goldens.py --update-goldens

writes those that are missing or have changed, and fails: look at each, and run again without. Only the driver named in
`goldens/driver.txt` writes. To change to another one, name it there, delete the pictures, and write them all.
"""

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from gpu_xform.device import Adapter
from tests.support.types import Pixels

FOLDER = Path(__file__).parents[1] / "goldens"
FAILURES = Path(__file__).parents[2] / "test-failures"

# Out of 255. Another driver may round differently everywhere, and light other pixels at the ends and crossings of thin
# lines.
ROUNDING = 1
MAX_MEAN = 0.1
LARGE_DIFFERENCE = 16
MAX_PIXELS = 24


def driver_of(adapter: Adapter) -> str:
    """Return what determines the pixels of a software driver: "llvmpipe, Mesa 22"."""
    return f"{adapter.name.split()[0]}, {adapter.driver.split('.')[0]}"


@dataclass(frozen=True)
class Goldens:
    """The golden pictures of a folder, and the driver they are compared on.

    folder : holds NAME.png, and in driver.txt the driver that drew them
    driver : of the device that draws now
    output : where a failure leaves NAME.actual.png, NAME.expected.png and NAME.difference.png; made if need be
    update : whether to write the pictures that differ, which fails as well
    """

    folder: Path
    driver: str
    output: Path
    update: bool = False

    def check(self, picture: Pixels, name: str) -> None:
        """Raise `AssertionError` if `picture` (height, width, 4) differs from the golden `name`.

        On the driver that drew it, each channel must agree to 1/255. On another, differences beyond that must be at
        most 0.1/255 on average, and more than 16/255 in at most 24 pixels.
        """
        __tracebackhide__ = True
        path = self.folder / f"{name}.png"
        problem = self._problem(picture, path)
        if problem is None:
            return
        if self.update:
            assert self._is_at_home, f"goldens are written by {self._drawn_by} only, this is {self.driver}"
            Image.fromarray(picture).save(path, optimize=True)
            raise AssertionError(f"wrote {path}: {problem}. Look at it, and run again without --update-goldens.")
        self._leave(picture, path)
        raise AssertionError(f"{problem}. The picture drawn, the golden and their difference are in {self.output}")

    @property
    def _drawn_by(self) -> str:
        return (self.folder / "driver.txt").read_text("utf-8").strip()

    @property
    def _is_at_home(self) -> bool:
        return self.driver == self._drawn_by

    def _problem(self, picture: Pixels, path: Path) -> str | None:
        if not path.is_file():
            return f"there is no golden {path.name}"
        golden = _read(path)
        if picture.shape != golden.shape:
            return f"{path.name} has shape {golden.shape}, got {picture.shape}"
        difference = np.abs(picture.astype(int) - golden)
        beyond = float(np.maximum(difference - ROUNDING, 0).mean())
        worst = difference.max(axis=-1)
        n_off, n_far_off = (int(np.count_nonzero(worst > limit)) for limit in (ROUNDING, LARGE_DIFFERENCE))
        if n_off == 0 or (not self._is_at_home and beyond <= MAX_MEAN and n_far_off <= MAX_PIXELS):
            return None
        row, column = np.unravel_index(worst.argmax(), worst.shape)
        return (
            f"{path.name} differs by more than {ROUNDING}/255 in {n_off} pixels of {worst.size}, "
            f"by more than {LARGE_DIFFERENCE}/255 in {n_far_off}, most by {worst.max()}/255 "
            f"in row {row}, column {column}, on {self.driver}, drawn by {self._drawn_by}"
        )

    def _leave(self, picture: Pixels, path: Path) -> None:
        """Write the picture drawn, the golden if there is one, and their difference if they have one shape."""
        self.output.mkdir(parents=True, exist_ok=True)
        actual, expected, difference = (
            self.output / f"{path.stem}.{role}.png" for role in ("actual", "expected", "difference")
        )
        for stale in (expected, difference):
            stale.unlink(missing_ok=True)
        Image.fromarray(picture).save(actual)
        if not path.is_file():
            return
        shutil.copyfile(path, expected)
        golden = _read(path)
        if picture.shape == golden.shape:
            worst = np.abs(picture.astype(int) - golden).max(axis=-1)
            visible = np.where(worst > 0, 64 + worst * 191 // 255, 0)  # a difference of 1/255 must be visible too
            Image.fromarray(visible.astype(np.uint8)).save(difference)


def _read(path: Path) -> Pixels:
    with Image.open(path) as image:
        return np.asarray(image)
