"""Damaged files for every reader: each must end in a mesh or a MeshError, soon. `make fuzz SECONDS=300`."""

import argparse
import io
import random
import sys
import time
import traceback
import warnings
from collections import Counter

import gpu_xform as gx
from tests.formats.test_damage import SEEDS, SNIPPETS

MAX_CPU_S = 2.0


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


def main() -> int:
    """Fuzz for some seconds; print what was found, and return how many files broke the promise."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 2**32)
    options = parser.parse_args()
    rng, end = random.Random(options.seed), time.monotonic() + options.seconds  # noqa: S311 - no secret
    outcomes: Counter[str] = Counter()
    broken, slowest = set[str](), (0.0, "")
    warnings.simplefilter("ignore")
    while time.monotonic() < end:
        kind, data = rng.choice(SEEDS)
        changed = mutate(data, rng)
        begin = time.process_time()
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
        slowest = max(slowest, (taken, kind))
        if taken > MAX_CPU_S:
            broken.add(f"{kind}: {taken:.1f} s: {changed[:400]!r}")
    print(
        f"seed {options.seed}: {sum(outcomes.values()):,} files: {dict(outcomes)}; slowest {slowest[0]:.2f} s of a CPU"
    )
    for line in sorted(broken):
        print(line)
    return min(len(broken), 1)


if __name__ == "__main__":
    sys.exit(main())
