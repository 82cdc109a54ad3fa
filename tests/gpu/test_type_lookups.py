"""Narrow lookups of C types find what cffi itself finds."""

import re
import subprocess
import sys
from typing import Any

import cffi  # type: ignore[import-untyped]
import pytest
from wgpu.backends.wgpu_native import ffi

import gpu_xform.gpu.adapters  # noqa: F401 - narrows the lookups

NAMES = sorted(name.removeprefix("typedef ") for name in ffi._parser._declarations if name.startswith("typedef WGPU"))
SIGNATURE = "void(WGPUDevice const *, WGPUErrorType, WGPUStringView, void *, void *)"


@pytest.fixture(scope="module")
def unchanged() -> cffi.FFI:
    """wgpu's declarations in an FFI that nobody has touched."""
    other = cffi.FFI()
    for source in ffi._cdefsources:
        other.cdef(source)
    return other


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        *(f"{name} *" for name in NAMES[:: len(NAMES) // 12]),
        *(f"{name}[]" for name in NAMES[1 :: len(NAMES) // 4]),
        *("WGPULimits", "WGPUChainedStruct * ", "WGPUBool const *", "struct WGPUStringView *", "enum WGPUErrorType"),
        *("uint8_t []", "uint32_t[4]", "uintptr_t", "char []", "void *", "int", "bool *"),
        *("void(*)(WGPULimits *, size_t)", SIGNATURE.replace("(", "(*)(", 1)),
    ],
)
def test_a_type_is_the_one_that_cffi_finds(text: str, unchanged: cffi.FFI) -> None:
    found, expected = ffi.typeof(text), unchanged.typeof(text)
    assert str(found) == str(expected)
    assert found.kind == expected.kind
    item: Any = getattr(found, "item", None)
    expected_item: Any = getattr(expected, "item", None)
    if item is not None and item.kind == "struct":
        assert item.fields is not None
        fields, expected_fields = (
            [(name, str(field.type), field.offset) for name, field in t.fields] for t in (item, expected_item)
        )
        assert fields == expected_fields
        assert ffi.sizeof(item) == unchanged.sizeof(expected_item)


def test_a_function_type_makes_callbacks() -> None:
    seen = []
    callback = ffi.callback(SIGNATURE, lambda *arguments: seen.append(arguments[1]))
    callback(ffi.NULL, 2, ffi.new("WGPUStringView *")[0], ffi.NULL, ffi.NULL)
    assert seen == [2]


def test_an_unknown_type_is_refused_as_before(unchanged: cffi.FFI) -> None:
    for other in (ffi, unchanged):
        with pytest.raises(cffi.CDefError, match=re.escape('cannot parse "WGPUNonesuch *"')):
            other.typeof("WGPUNonesuch *")


def test_all_names_are_declared_afterwards() -> None:
    ffi.typeof("WGPUBufferDescriptor * *")
    assert {f"typedef {name}" for name in NAMES} <= ffi._parser._declarations.keys()


@pytest.mark.slow
def test_opening_a_device_reads_few_names() -> None:
    code = """
import pycparser.c_parser as c
parse, lengths = c.CParser.parse, []
c.CParser.parse = lambda self, text, *rest: lengths.append(text.count("typedef")) or parse(self, text, *rest)
import gpu_xform.gpu.adapters
lengths.clear()
gpu_xform.gpu.adapters.adapters()
print(len(lengths), max(lengths))
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    n_parses, most_names = map(int, ran.stdout.split())
    assert n_parses > 3
    assert most_names < 20
