"""Damaged files for every reader: each must end in a mesh or a MeshError, soon, in little memory.

`make fuzz SECONDS=300`; for one reader, `python -m tests.fuzz.readers --kinds wrl --seconds 900`.
"""

import argparse
import io
import random
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

import gpu_xform as gx
from tests.formats.test_damage import SEEDS, SNIPPETS
from tests.support.las_files import make_las

MAX_CPU_S = 2.0
MAX_GROWTH_BYTES = 256 << 20  # of the process, while it reads a file
MAX_FILE_BYTES = 1_000_000
FILES_PER_LARGE_FILE = 300


def save_array() -> bytes:
    """Return a `.npy` file of points, which has no faces, and so is no seed of the tests."""
    file = io.BytesIO()
    np.save(file, np.arange(24, dtype=np.float32).reshape(8, 3))
    return file.getvalue()


def save_scan() -> tuple[bytes, bytes]:
    """Return a `.las` file with extra bytes, and the same as `.laz`."""
    with tempfile.TemporaryDirectory() as folder:
        scan = make_las(Path(folder, "a.las"), 60, 7)
        scan.write(Path(folder, "a.laz"))
        return Path(folder, "a.las").read_bytes(), Path(folder, "a.laz").read_bytes()


ALL_SEEDS = [*SEEDS, ("npy", save_array()), *zip(("las", "laz"), save_scan(), strict=True)]


def mutate(data: bytes, rng: random.Random) -> bytes:
    """Return a file with a few bytes cut out, flipped, replaced, repeated or copied from elsewhere in it."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        place, other = rng.randrange(len(changed) + 1), rng.randrange(len(changed) + 1)
        match rng.randrange(6):
            case 0 if len(changed) > 20:
                del changed[place : place + rng.randint(1, 20)]
            case 1 if place < len(changed):
                changed[place] ^= 1 << rng.randrange(8)
            case 2:
                changed[place : place + rng.randint(0, 4)] = rng.choice(SNIPPETS)
            case 3:
                changed[place:place] = changed[place : place + rng.randint(1, 60)] * rng.choice((1, 1, 1, 50))
            case _:
                changed[place:place] = changed[other : other + rng.randint(1, 40)]
    return bytes(changed)


def enlarge(data: bytes, rng: random.Random) -> bytes:
    """Return a file in which some part is repeated, up to MAX_FILE_BYTES, as what takes long or much memory has it."""
    begin = rng.randrange(len(data) or 1)
    part = data[begin : begin + rng.choice((1, 2, 5, 10, 30, 100, 300))] or b" "
    n = (MAX_FILE_BYTES - len(data)) // len(part)
    return data[:begin] + part * rng.choice((n, n // 10)) + data[begin:]


def reset_peak() -> None:
    """Let Linux forget the most memory that this process has had; elsewhere, do nothing."""
    clear = Path("/proc/self/clear_refs")
    if clear.exists():
        clear.write_text("5")


def read_memory(name: str) -> int:
    """Return a figure of this process's memory in bytes: VmHWM for the most, VmRSS for what it is now; 0 off Linux."""
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith(name)), 0)


def main() -> int:
    """Fuzz for some seconds; print what was found, and return how many files broke the promise."""
    kinds = sorted({kind for kind, _ in ALL_SEEDS})
    parser = argparse.ArgumentParser()
    parser.add_argument("--kinds", default=",".join(kinds), help="the readers, separated by commas")
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 2**32)
    options = parser.parse_args()
    rng, end = random.Random(options.seed), time.monotonic() + options.seconds  # noqa: S311 - no secret
    seeds = [(kind, data) for kind, data in ALL_SEEDS if kind in options.kinds.split(",")]
    if not seeds:
        parser.error(f"--kinds: expected some of {','.join(kinds)}")
    outcomes: Counter[str] = Counter()
    files: Counter[str] = Counter()
    broken, slowest, largest = set[str](), (0.0, ""), (0, "")
    warnings.simplefilter("ignore")
    first = time.process_time()
    while time.monotonic() < end:
        kind, data = rng.choice(seeds)
        changed = mutate(data, rng)
        is_large = rng.randrange(FILES_PER_LARGE_FILE) == 0
        if is_large:
            changed = enlarge(rng.choice((data, data, changed)), rng)
            reset_peak()
        before, begin = read_memory("VmRSS") if is_large else 0, time.process_time()
        try:
            gx.load_mesh(io.BytesIO(changed), file_type=kind)
            outcomes["mesh"] += 1
        except gx.MeshError:
            outcomes["MeshError"] += 1
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            outcomes["other"] += 1
            broken.add(f"{kind}: {type(error).__name__} at {last.filename}:{last.lineno}: {changed[:400]!r}")
        taken = time.process_time() - begin
        grown = read_memory("VmHWM") - before if is_large else 0
        files[kind] += 1
        slowest, largest = max(slowest, (taken, kind)), max(largest, (grown, kind))
        if taken > MAX_CPU_S or grown > MAX_GROWTH_BYTES:
            broken.add(f"{kind}: {taken:.1f} s, {grown >> 20} MiB: {len(changed)} bytes, {changed[:400]!r}")
    print(
        f"seed {options.seed}: {sum(outcomes.values()):,} files in {time.process_time() - first:.0f} s of a processor: "
        f"{dict(outcomes)}; slowest {slowest[0]:.2f} s ({slowest[1]}); most memory {largest[0] >> 20} MiB "
        f"({largest[1]})"
    )
    print(", ".join(f"{kind} {count:,}" for kind, count in sorted(files.items())))
    for line in sorted(broken):
        print(line)
    return min(len(broken), 1)


if __name__ == "__main__":
    sys.exit(main())
