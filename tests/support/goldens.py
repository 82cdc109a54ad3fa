"""Pictures kept beside the tests, so that none changes unnoticed.

    pytest tests/test_goldens.py --update-goldens

writes those that are missing or have changed, and fails: look at each, and run again without. Only the driver named in
`goldens/driver.txt` writes. To go over to another one, name it there, delete the pictures, and write them all.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from gpu_xform.gpu.adapters import Adapter

Pixels = npt.NDArray[np.uint8]

FOLDER = Path(__file__).parents[1] / "goldens"

# Of 255. Another driver may round otherwise everywhere, and light other pixels at the ends and crossings of thin lines.
ROUNDING = 1
MOST_ON_AVERAGE = 0.1
MUCH = 16
MOST_PIXELS = 24


def driver_of(adapter: Adapter) -> str:
    """Return what decides on the pixels of a software driver: "llvmpipe, Mesa 22"."""
    return f"{adapter.name.split()[0]}, {adapter.driver.split('.')[0]}"


@dataclass(frozen=True)
class Goldens:
    """What pictures are held against.

    folder : holds NAME.png, and in driver.txt the driver that drew them
    driver : of the device that draws now
    output : where what was drawn instead goes, and how it differs
    update : whether to write the pictures that differ; that fails as well
    """

    folder: Path
    driver: str
    output: Path
    update: bool = False

    def check(self, picture: Pixels, name: str) -> None:
        """Raise `AssertionError` where `picture` (height, width, 4) is not the one kept as `name`.

        On the driver that drew it, each channel must agree to 1/255. On another, what goes beyond must be at most
        0.1/255 on average, and more than 16/255 in at most 24 pixels.
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
        Image.fromarray(picture).save(self.output / f"{name}.actual.png")
        raise AssertionError(f"{problem}. What was drawn, and how it differs, is in {self.output}")

    @property
    def _drawn_by(self) -> str:
        return (self.folder / "driver.txt").read_text("utf-8").strip()

    @property
    def _is_at_home(self) -> bool:
        return self.driver == self._drawn_by

    def _problem(self, picture: Pixels, path: Path) -> str | None:
        if not path.is_file():
            return f"there is no golden {path.name}"
        with Image.open(path) as image:
            golden = np.asarray(image)
        if picture.shape != golden.shape:
            return f"{path.name} has shape {golden.shape}, got {picture.shape}"
        difference = np.abs(picture.astype(int) - golden)
        beyond = float(np.maximum(difference - ROUNDING, 0).mean())
        worst = difference.max(axis=-1)
        n_off, n_far_off = (int(np.count_nonzero(worst > limit)) for limit in (ROUNDING, MUCH))
        if n_off == 0 or (not self._is_at_home and beyond <= MOST_ON_AVERAGE and n_far_off <= MOST_PIXELS):
            return None
        shown = np.where(worst > 0, 64 + worst * 191 // 255, 0).astype(np.uint8)  # 1/255 shows as well
        Image.fromarray(shown).save(self.output / f"{path.stem}.difference.png")
        row, column = np.unravel_index(worst.argmax(), worst.shape)
        return (
            f"{path.name} differs by more than {ROUNDING}/255 in {n_off} pixels of {worst.size}, "
            f"by more than {MUCH}/255 in {n_far_off}, most by {worst.max()}/255 in row {row}, column {column}, "
            f"on {self.driver}, drawn by {self._drawn_by}"
        )
