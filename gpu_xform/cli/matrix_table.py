"""Tables of one matrix per file, as registration tools write them: JSON, CSV, and COLMAP's images.txt.

- Open3D writes 4x4 matrices column by column: the `pose` of each node of a pose graph leads from its cloud to the
  common frame; the `extrinsic` of each view of a camera trajectory leads from the world to the camera, and is inverted.
- COLMAP writes, per image, the rotation and translation from the world to the camera, which are inverted, and for the
  alignment of two models a similarity: scale, quaternion w, x, y, z, translation.
- CloudCompare writes a text of 16 numbers, row by row, per cloud: a table may name such files, or be one.
- Other tools write a CSV with titles: those of a quaternion and a translation are found in any order.
"""

import csv
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError
from . import files
from .paths import file_type

_NAME_KEYS = ("file", "name", "path", "tile", "image", "filename", "scan", "cloud")
_MATRIX_KEYS = ("matrix", "transformation", "transform", "pose")
_POSE_TITLES = {
    "scale": 0, "s": 0, "qw": 1, "qx": 2, "qy": 3, "qz": 4, "tx": 5, "ty": 6, "tz": 7, "x": 5, "y": 6, "z": 7,
}  # fmt: skip
_POSE_PARTS = {*range(1, 8)}
_DECIMAL_COMMA = re.compile(r"[;\t]\s*-?\d+,\d")
_MAX_UNIT_ERROR = 0.01  # of a quaternion: more is a column that is something else


class MatrixTable:
    """Matrices by the names of files, or in the order of the files where the table names none."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._by_name: dict[str, Float64Array] = {}
        self._in_order: list[Float64Array] = []
        self._used: set[str] = set()
        try:
            self._read()
        except (UnicodeDecodeError, json.JSONDecodeError, csv.Error, RecursionError) as error:
            raise ArgumentError(f"{path}: expected JSON, CSV or COLMAP's images.txt: {error}") from None

    def find(self, file: str, place: int, count: int) -> Float64Array:
        """Return the matrix of a file, the one at `place` of `count`."""
        if self._in_order:
            if len(self._in_order) != count:
                raise ArgumentError(f"{self._path}: {len(self._in_order)} matrices without names for {count} files")
            return self._in_order[place]
        name = self._find_name(file)
        self._used.add(name)
        return self._by_name[name]

    def _find_name(self, file: str) -> str:
        """Return the name under which a file stands: whole, without its folder, or without its type as well."""
        path = Path(file)
        for name in (file, path.name, path.stem):
            if name in self._by_name:
                return name
        for shorten in (_name_of, _stem_of):
            found = [name for name in self._by_name if shorten(name) == shorten(file)]
            if len(found) == 1:
                return found[0]
            if found:
                raise ArgumentError(f"{self._path}: {len(found)} matrices may be that of {file}: {', '.join(found)}")
        numbers = _list_numbers(path.name)
        known = [name for name in self._by_name if _list_numbers(name) == numbers]  # with others it is another tile
        raise ArgumentError(f"{self._path}: no matrix for {file}{did_you_mean(path.name, known)}")

    @property
    def unused(self) -> list[str]:
        """Names that no file asked for."""
        return [name for name in self._by_name if name not in self._used]

    def _read(self) -> None:
        text = Path(self._path).read_text("utf-8-sig")
        kind = file_type(self._path)
        if kind == "json":
            self._read_json(json.loads(text))
        elif text.lstrip().startswith("# Image list") or Path(self._path).name.lower() == "images.txt":
            self._read_colmap_images(text)
        elif (blocks := _list_blocks(text)) is not None:
            for i, block in enumerate(blocks):
                self._add(None, block, f"matrix {i}")
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
            match content.get("class_name"):
                case "PoseGraph":
                    for i, node in enumerate(self._list_of(content, "nodes")):
                        self._add(None, self._by_columns(node, "pose", f"node {i}"), f"node {i}")
                case "PinholeCameraTrajectory":
                    for i, view in enumerate(self._list_of(content, "parameters")):
                        extrinsic = self._by_columns(view, "extrinsic", f"view {i}")
                        self._add(None, self._invert(extrinsic, f"view {i}"), f"view {i}")
                case "PinholeCameraParameters":
                    extrinsic = self._by_columns(content, "extrinsic", "extrinsic")
                    self._add(None, self._invert(extrinsic, "extrinsic"), "extrinsic")
                case _:
                    for name, value in content.items():
                        self._add(str(name), self._as_matrix(_take_matrix(value), repr(name)), repr(name))
            return
        if not isinstance(content, Sequence) or isinstance(content, str):
            raise ArgumentError(f"{self._path}: expected matrices by name, or a list of them, got {content!r}")
        for i, value in enumerate(content):
            name = None
            if isinstance(value, Mapping):
                name = next((str(value[key]) for key in _NAME_KEYS if key in value), None)
            self._add(name, self._as_matrix(_take_matrix(value), f"entry {i}"), f"entry {i}")

    def _list_of(self, content: Mapping[str, Any], key: str) -> Sequence[Any]:
        found = content.get(key)
        if not isinstance(found, list):
            raise ArgumentError(f"{self._path}: {content['class_name']} without a list of {key}")
        return found

    def _by_columns(self, content: Any, key: str, where: str) -> Float64Array:
        numbers = content.get(key) if isinstance(content, Mapping) else None
        try:
            return np.array(numbers, np.float64).reshape(4, 4).T
        except (TypeError, ValueError):
            raise ArgumentError(f"{self._path}: {where}: expected 16 numbers as {key}, got {numbers!r}") from None

    def _invert(self, matrix: Float64Array, where: str) -> Float64Array:
        """Return the matrix from a camera to the world, of one the other way."""
        try:
            return np.asarray(np.linalg.inv(matrix), np.float64)
        except np.linalg.LinAlgError:
            raise ArgumentError(f"{self._path}: {where}: the pose of a camera must have an inverse") from None

    def _read_csv(self, text: str) -> None:
        lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        delimiter = next((mark for mark in ",;\t" if lines and mark in lines[0]), ",")
        for i, line in enumerate(lines):
            if _DECIMAL_COMMA.search(line):
                raise ArgumentError(f"{self._path}: line {i + 1}: expected decimal points, got commas: {line[:60]!r}")
        columns: list[str] = []
        for i, row in enumerate(csv.reader(lines, delimiter=delimiter, skipinitialspace=True)):
            cells = [cell.strip() for cell in row]
            if len(cells) == 1:
                cells = cells[0].split()
            has_name = not _is_number(cells[0]) or len(cells) in (9, 13, 17)
            name, values = (cells[0], cells[1:]) if has_name else (None, cells)
            if has_name and not any(map(_is_number, values)):
                if i == 0 and len(values) > 1:
                    columns = [title.strip().lower() for title in cells]
                    continue
                self._add(name, self._as_matrix(" ".join(values), f"line {i + 1}"), f"line {i + 1}")
                continue
            places = [_POSE_TITLES.get(title) for title in columns]
            if len(columns) == len(cells) and {*places} >= _POSE_PARTS:
                name, values = self._order_pose(cells, columns, places)
            self._add(name, self._as_matrix(values, f"line {i + 1}"), f"line {i + 1}")

    def _order_pose(
        self, cells: Sequence[str], titles: Sequence[str], places: Sequence[int | None]
    ) -> tuple[str | None, list[str]]:
        """Return the name, and scale, quaternion and translation, of cells in the order of their titles."""
        pose = ["1"] + [""] * 7
        for cell, place in zip(cells, places, strict=True):
            if place is not None:
                pose[place] = cell
        known = next((cell for cell, title in zip(cells, titles, strict=True) if title in _NAME_KEYS), None)
        first = next((cell for cell in cells if not _is_number(cell)), None)
        return known if known is not None else first, pose

    def _read_colmap_images(self, text: str) -> None:
        for line in text.splitlines():
            words = line.split(maxsplit=9)
            is_pose = len(words) == 10 and all(map(_is_number, words[:9]))
            if not is_pose or (_is_number(words[9].split()[0]) and len(line.split()) > 10):  # points of an image
                continue
            name = words[9].strip()
            pose = self._as_matrix([1.0, *map(float, words[1:8])], name)
            self._add(name, self._invert(pose, name), name)

    def _as_matrix(self, value: Any, where: str) -> Float64Array:
        """Return 4x4 of rows, of 16 or 12 numbers row by row, of a similarity, or of the file that a text names."""
        if isinstance(value, str):
            path = Path(self._path).parent / value
            if not path.is_file():
                raise ArgumentError(
                    f"{self._path}: {where}: expected 16 numbers, or the name of a file of them, got {value[:60]!r}"
                )
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
                return self._from_similarity(numbers.ravel().tolist(), where)
        raise ArgumentError(
            f"{self._path}: {where}: expected 16 numbers or 12, row by row, or 8: scale, quaternion w, x, y, z, "
            f"translation; got {value!r}"
        )

    def _from_similarity(self, numbers: Sequence[float], where: str) -> Float64Array:
        """Return the matrix of a scale, a quaternion w, x, y, z and a translation."""
        scale, w, x, y, z, *translation = numbers
        length = float(np.linalg.norm([w, x, y, z]))
        if not (scale > 0 and abs(length - 1) <= _MAX_UNIT_ERROR):
            raise ArgumentError(
                f"{self._path}: {where}: expected a positive scale, a quaternion w, x, y, z of length 1, and a "
                f"translation, got {list(numbers)}"
            )
        w, x, y, z = np.array([w, x, y, z]) / length
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


def _take_matrix(value: Any) -> Any:
    """Return what an entry of JSON has as its matrix."""
    return next((value[key] for key in _MATRIX_KEYS if key in value), None) if isinstance(value, Mapping) else value


def _list_blocks(text: str) -> list[Float64Array] | None:
    """Return the matrices of a text that is four rows of four numbers each, maybe below a line of three; else None."""
    rows = [line.replace(",", " ").split() for line in text.splitlines() if line.strip() and line.lstrip()[0] != "#"]
    if not rows or not all(_is_number(word) for row in rows for word in row):
        return None
    if len(rows[0]) == 3 and len(rows) % 5 == 0 and all(len(row) == 3 for row in rows[::5]):  # a log of Open3D
        rows = [row for i, row in enumerate(rows) if i % 5]
    if len(rows) % 4 or any(len(row) != 4 for row in rows):
        return None
    return list(np.array(rows, np.float64).reshape(-1, 4, 4))


def _name_of(path: str) -> str:
    return path.replace("\\", "/").rpartition("/")[2]


def _list_numbers(name: str) -> list[str]:
    """Return the numbers in a name, without zeros before them."""
    return [digits.lstrip("0") for digits in re.findall(r"[0-9]+", name)]


def _stem_of(path: str) -> str:
    name = _name_of(path)
    stem = name.rpartition(".")[0] or name
    return stem.removesuffix(".copc")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
