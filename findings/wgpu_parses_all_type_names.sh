#!/usr/bin/env bash
# wgpu 0.32.0, cffi 2.1.1, pycparser 3.12, CPython 3.11, Linux x86-64.
#
# Behaviour: wgpu-native's binding hands cffi the whole of wgpu.h once (ABI mode). After that, the first use of every type
# ("WGPUExtent3D *") lets pycparser read one typedef for each type name of the header before the name asked for: 17 kB of
# C for 14 letters. A program opens its first device, makes its first buffer and its first pipeline with dozens of such
# first uses; together they took about half the time to a first picture of a program that draws one and ends.
#
# The guess before: the header is parsed once, at import; looking up a type after that is a dict access, or at worst a
# parse of the few letters asked for (171 characters for an FFI with one type, which is mostly cffi's own preamble).
#
# Seen:
#   at import:           3 texts parsed
#   one type name:       17270 characters parsed for 14
#   the same once more:  0 characters parsed
#   an FFI of one type:  171 characters parsed for 3
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install wgpu==0.32.0 cffi==2.1.1 pycparser==3.12
"$folder/venv/bin/python" - <<'PYTHON'
from pycparser import c_parser

lengths = []
parse = c_parser.CParser.parse


def counting(self, text, *args, **kwargs):
    lengths.append(len(text))
    return parse(self, text, *args, **kwargs)


c_parser.CParser.parse = counting
from wgpu.backends.wgpu_native import ffi
from cffi import FFI

at_import = len(lengths)
ffi.typeof("WGPUExtent3D *")
first = sum(lengths[at_import:])
before = len(lengths)
ffi.typeof("WGPUExtent3D *")
again = sum(lengths[before:])
small = FFI()
small.cdef("typedef struct { int a; } X;")
before = len(lengths)
small.typeof("X *")
alone = sum(lengths[before:])
print(f"at import:           {at_import} texts parsed")
print(f"one type name:       {first} characters parsed for 14")
print(f"the same once more:  {again} characters parsed")
print(f"an FFI of one type:  {alone} characters parsed for 3")
assert first > 15_000 and again == 0 and alone < 1_000
PYTHON
