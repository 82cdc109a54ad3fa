"""Labels as a layer takes them: which texts, at which points."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

from .._core.arguments import as_int, as_vector, require_room
from .._core.masked import Mask
from .._core.suggestions import did_you_mean
from ..errors import ArgumentError, ArgumentTypeError

NAMES: Literal["names"] = "names"
INDICES: Literal["indices"] = "indices"
_SETS = (NAMES, INDICES)

PointKey: TypeAlias = int | tuple[float, float, float]
LabelsLike: TypeAlias = Literal["names", "indices"] | Sequence[str | None] | Mapping[PointKey, str]


class InstanceNames(tuple[str, ...]):
    """The name of each instance of a layer, to be written at its centre."""


def check_labels(labels: Any) -> LabelsLike | InstanceNames | None:
    """Return labels as a tuple of texts, a dict, or one of the words; raise an error for anything else."""
    if labels is None or isinstance(labels, InstanceNames):
        return labels
    if isinstance(labels, str):
        if labels not in _SETS:
            hint = did_you_mean(labels, _SETS)
            expected = "be 'names', 'indices', a text per point, or a dict from points to texts"
            raise ArgumentError.expecting("labels", expected, f"{labels!r}{hint}")
        return NAMES if labels == NAMES else INDICES
    if isinstance(labels, Mapping):
        return {_check_key(key): _check_text(text, f"labels[{key!r}]") or "" for key, text in labels.items()}
    if isinstance(labels, np.ndarray):
        require_room(labels, "labels")
        labels = labels.tolist()
    if not isinstance(labels, Sequence):
        expected = "be 'names', 'indices', a text per point, or a dict from points to texts"
        raise ArgumentTypeError.expecting("labels", expected, type(labels).__name__)
    return tuple(_check_text(text, f"labels[{i}]") for i, text in enumerate(labels))


def drop_hidden_labels(labels: Any, hidden: Mask) -> Any:
    """Return labels of n points without those of the points that a mask (n,) hides: the others are counted anew."""
    if isinstance(labels, Mapping):
        new_index = np.cumsum(~hidden) - 1
        indices = [key for key in labels if not isinstance(key, tuple) and -len(hidden) <= key < len(hidden)]
        shown = {int(new_index[key]): labels[key] for key in indices if not hidden[key]}
        return shown | {key: text for key, text in labels.items() if key not in indices}
    if labels is None or isinstance(labels, str) or not hasattr(labels, "__len__") or len(labels) != len(hidden):
        return labels
    return [text for text, is_hidden in zip(labels, hidden.tolist(), strict=True) if not is_hidden]


def _check_key(key: Any) -> PointKey:
    if isinstance(key, tuple):
        x, y, z = as_vector(key, "a key of labels", 3).tolist()
        return x, y, z
    return as_int(key, "a key of labels, if it is no point (x, y, z),")


def _check_text(text: Any, name: str) -> str | None:
    if text is not None and not isinstance(text, str):
        raise ArgumentTypeError.expecting(name, "be a text", repr(text))
    return text
