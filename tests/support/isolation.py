"""What is carried out of isolation."""

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from gpu_xform.formats.isolation_values import create_memory, decode, dump, encode


def carry(value: Any) -> tuple[bytes, Any]:
    """Return the text of a value that leaves isolation, and what is read of it."""
    memory = create_memory()
    try:
        text = dump(encode(value, memory, 1 << 30))
        return text, decode(json.loads(text), memory)
    finally:
        os.close(memory)


def assert_same(value: Any, expected: Any) -> None:
    """Compare what a scene is described by, deeply and to the bit."""
    if isinstance(expected, np.ndarray):
        assert (value.dtype, value.tobytes()) == (expected.dtype, expected.tobytes())
    elif isinstance(expected, Mapping):
        assert list(value) == list(expected)
        for key, each in expected.items():
            assert_same(value[key], each)
    elif isinstance(expected, list | tuple):
        assert len(value) == len(expected)
        for one, other in zip(value, expected, strict=True):
            assert_same(one, other)
    else:
        assert value == expected
