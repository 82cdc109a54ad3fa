#!/usr/bin/env bash
# numba 0.68.1, NumPy 2.4.6, Python 3.11, Linux with /sys/kernel/mm/transparent_hugepage/enabled at its usual "madvise".
#
# Behaviour: `np.empty` of 64 MB and a write of each number cost 30 to 500 times as many page faults inside a compiled
# function as outside. NumPy asks the kernel for huge pages (madvise) from 4 MB on; numba's runtime takes malloc's pages
# of 4 kB as they are. The function that writes is the same: only who makes the array differs.
#
# The guess before: both take fresh memory from malloc, and fault once per 4 kB, 16,384 times.
#
# Seen (page faults of a call):
#   made by numba: 16385
#   made by NumPy: 544, of which 512 are the ends that are no whole huge page
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
grep -q '\[madvise\]' /sys/kernel/mm/transparent_hugepage/enabled
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install numba==0.68.1 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import resource

import numba
import numpy as np

N_NUMBERS = 1 << 24
N_CALLS = 3


@numba.njit
def fill(numbers):
    numbers[:] = 1.0
    return numbers[-1]


@numba.njit
def make_and_fill(n):
    return fill(np.empty(n, np.float32))


def count_faults(run):
    run()  # compiles
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(N_CALLS):
        run()
    return (resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before) // N_CALLS


by_numba = count_faults(lambda: make_and_fill(N_NUMBERS))
by_numpy = count_faults(lambda: fill(np.empty(N_NUMBERS, np.float32)))
print(f"made by numba: {by_numba}")
print(f"made by NumPy: {by_numpy}")
assert by_numba >= 4 * N_NUMBERS // 4096
assert by_numpy * 20 < by_numba
PYTHON
