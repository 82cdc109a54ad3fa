"""Tables of one matrix per file, as registration tools write them: JSON, CSV, and COLMAP's images.txt.

- Open3D writes 4x4 matrices column by column: the `pose` of each node of a pose graph leads from its cloud to the
  common frame; the `extrinsic` of each view of a camera trajectory leads from the world to the camera, and is inverted.
- COLMAP writes, per image, the rotation and translation from the world to the camera, which are inverted, and for the
  alignment of two models a similarity: scale, quaternion w, x, y, z, translation.
- CloudCompare writes a text of 16 numbers, row by row, per cloud: a table may name such files.
"""

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError
from . import files
from .paths import file_type

_NAME_KEYS = ("file", "name", "path", "tile", "image")
_MATRIX_KEYS = ("matrix", "transformation", "transform", "pose")


class MatrixTable:
    """Matrices by the names of files, or in the order of the files where the table names none."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._by_name: dict[str, Float64Array] = {}
        self._in_order: list[Float64Array] = []
        try:
            self._read()
        except (UnicodeDecodeError, json.JSONDecodeError, csv.Error) as error:
            raise ArgumentError(f"{path}: expected JSON, CSV or COLMAP's images.txt: {error}") from None

    def find(self, file: str, place: int, count: int) -> Float64Array:
        """Return the matrix of a file, the one at `place` of `count`."""
        if self._in_order:
            if len(self._in_order) != count:
                raise ArgumentError(f"{self._path}: {len(self._in_order)} matrices without names for {count} files")
            return self._in_order[place]
        path = Path(file)
        for name in (file, path.name, path.stem):
            if name in self._by_name:
                return self._by_name[name]
        raise ArgumentError(f"{self._path}: no matrix for {file}")

    def _read(self) -> None:
        text = Path(self._path).read_text("utf-8-sig")
        kind = file_type(self._path)
        if kind == "json":
            self._read_json(json.loads(text))
        elif text.lstrip().startswith("# Image list"):
            self._read_colmap_images(text)
        else:
            self._read_csv(text)

    def _add(self, name: str | None, matrix: Float64Array, where: str) -> None:
        if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
            raise ArgumentError(f"{self._path}: {where}: expected a finite matrix 4x4, got {matrix.tolist()}")
        if name is None:
            self._in_order.append(matrix)
        elif name in self._by_name:
            raise ArgumentError(f"{self._path}: {where}: a second matrix for {name}")
        else:
            self._by_name[name] = matrix
        if self._in_order and self._by_name:
            raise ArgumentError(f"{self._path}: {where}: matrices with a name and without one")

    def _read_json(self, content: Any) -> None:
        if isinstance(content, Mapping):
            kind = content.get("class_name")
            if kind == "PoseGraph":
                for i, node in enumerate(content["nodes"]):
                    self._add(None, _by_columns(node["pose"]), f"node {i}")
                return
            if kind == "PinholeCameraTrajectory":
                for i, view in enumerate(content["parameters"]):
                    self._add(None, _invert(_by_columns(view["extrinsic"])), f"view {i}")
                return
            for name, value in content.items():
                self._add(str(name), self._as_matrix(value, repr(name)), repr(name))
            return
        if not isinstance(content, Sequence) or isinstance(content, str):
            raise ArgumentError(f"{self._path}: expected matrices by name, or a list of them, got {content!r}")
        for i, value in enumerate(content):
            name = None
            if isinstance(value, Mapping):
                name = next((str(value[key]) for key in _NAME_KEYS if key in value), None)
                value = next((value[key] for key in _MATRIX_KEYS if key in value), None)
            self._add(name, self._as_matrix(value, f"entry {i}"), f"entry {i}")

    def _read_csv(self, text: str) -> None:
        lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        for i, row in enumerate(csv.reader(lines, skipinitialspace=True)):
            cells = [cell.strip() for cell in row]
            if len(cells) == 1:
                cells = cells[0].split()
            name = None if _is_number(cells[0]) else cells[0]
            values: Any = cells if name is None else cells[1:]
            if name is not None and not any(map(_is_number, values)):
                if i == 0 and len(values) > 1:  # the titles of columns
                    continue
                values = " ".join(values)
            self._add(name, self._as_matrix(values, f"line {i + 1}"), f"line {i + 1}")

    def _read_colmap_images(self, text: str) -> None:
        lines = [line for line in text.splitlines() if not line.startswith("#")]
        for line in lines[::2]:  # each is followed by a line of its points
            words = line.split(maxsplit=9)
            if len(words) == 10:
                numbers = [float(word) for word in words[1:8]]
                self._add(words[9].strip(), _invert(_from_similarity([1.0, *numbers])), words[9])

    def _as_matrix(self, value: Any, where: str) -> Float64Array:
        """Return 4x4 of rows, of 16 or 12 numbers row by row, of a similarity, or of the file that a text names."""
        if isinstance(value, str):
            path = Path(self._path).parent / value
            return np.asarray(files.read_matrix(str(path)), np.float64)
        try:
            numbers = np.array(value, np.float64)
        except (TypeError, ValueError):
            numbers = np.empty(0)
        match numbers.size:
            case 16:
                return numbers.reshape(4, 4)
            case 12:
                return np.vstack([numbers.reshape(3, 4), [0, 0, 0, 1]])
            case 8:
                return _from_similarity(numbers.tolist())
        raise ArgumentError(
            f"{self._path}: {where}: expected 16 numbers or 12, row by row, or 8: scale, quaternion w, x, y, z, "
            f"translation; got {value!r}"
        )


def _by_columns(numbers: Sequence[float]) -> Float64Array:
    return np.array(numbers, np.float64).reshape(4, 4).T


def _invert(matrix: Float64Array) -> Float64Array:
    return np.asarray(np.linalg.inv(matrix), np.float64)


def _from_similarity(numbers: Sequence[float]) -> Float64Array:
    """Return the matrix of a scale, a quaternion w, x, y, z and a translation."""
    scale, w, x, y, z, *translation = numbers
    w, x, y, z = np.array([w, x, y, z]) / (np.linalg.norm([w, x, y, z]) or 1.0)
    matrix = np.identity(4)
    matrix[:3, :3] = scale * np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix[:3, 3] = translation
    return matrix


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
