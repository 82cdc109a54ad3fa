"""Damaged files for every reader: each must end in a mesh or a MeshError, soon, in little memory.

`make fuzz SECONDS=300`; for one reader, `python -m tests.fuzz.readers --kinds wrl --seconds 900`.
"""

import argparse
import os
import random
import sys
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.formats.test_damage import SNIPPETS
from tests.fuzz.seeds import Seed, list_seeds, make_folder

MAX_CPU_S = 2.0
MAX_GROWTH_BYTES = 256 << 20  # of the process, while it reads a file
NOTED_GROWTH_BYTES = 16 << 20  # more than that would hide what the next files take
MAX_FILE_BYTES = 1_000_000
MAX_PROCESS_BYTES = 6 << 30
FILES_PER_LARGE_FILE = 300
MAX_SHOWN_BYTES = 400


def mutate(data: bytes, rng: random.Random) -> bytes:
    """Return a file with a few bytes cut out, flipped, replaced, repeated or copied from elsewhere in it."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
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
    """Return a file of which a part or two are repeated, up to MAX_FILE_BYTES, as what takes long or much memory has.

    Two parts: a long one beside many short ones may take as much for each.
    """
    n_parts = rng.choice((1, 2))
    for k in range(n_parts):
        begin = rng.randrange(len(data) or 1)
        part = data[begin : begin + rng.choice((1, 2, 5, 10, 30, 100, 300))] or b" "
        n = (MAX_FILE_BYTES - len(data)) // len(part) // (n_parts - k)
        data = data[:begin] + part * rng.choice((n, n // 10)) + data[begin:]
    return data


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


def read_peak() -> int:
    """Return the most memory that this process has had since `reset_peak`, in bytes; 0 off Linux."""
    if sys.platform != "linux":
        return 0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024  # a tenth of the time that /proc takes


def limit_memory() -> None:
    """Let a file that takes all memory be an error of this process, where the system can, and not of the machine."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MAX_PROCESS_BYTES, resource.getrlimit(resource.RLIMIT_AS)[1]))


def count_cpu_s() -> float:
    """Return the seconds of a processor that this process and its children, which have ended, took."""
    ended = os.times()
    return time.process_time() + ended.children_user + ended.children_system


@dataclass
class Tally:
    """What came of the files of one kind."""

    outcomes: Counter[str] = field(default_factory=Counter)
    cpu_s: float = 0.0
    slowest_s: float = 0.0
    largest_bytes: int = 0

    def describe(self) -> str:
        """Return a line of figures."""
        return (
            f"{self.outcomes.total():,} files in {self.cpu_s:.0f} s of a processor: {dict(self.outcomes)}; "
            f"slowest {self.slowest_s:.2f} s; most memory {self.largest_bytes >> 20} MiB"
        )


class Fuzzer:
    """Damaged files, one after the other, and what broke a promise: for each way an example."""

    def __init__(self, seeds: list[Seed], number: int) -> None:
        self._seeds: dict[str, list[Seed]] = {}
        for seed in seeds:
            self._seeds.setdefault(seed.kind, []).append(seed)
        self._rng = random.Random(number)  # noqa: S311 - no secret
        self.tallies = {kind: Tally() for kind in self._seeds}
        self.broken: dict[str, bytes] = {}
        self._before, self._is_peak_old = 0, True  # memory before the files since the peak was reset, if it still holds

    def try_file(self) -> None:
        """Damage a file of the kind that has had the least time, and read it."""
        rng, kind = self._rng, min(self.tallies, key=lambda kind: self.tallies[kind].cpu_s)
        seed = rng.choice(self._seeds[kind])
        data = mutate(seed.data, rng)
        is_large = rng.randrange(FILES_PER_LARGE_FILE) == 0
        if is_large:
            data = enlarge(rng.choice((seed.data, seed.data, data)), rng)
        if is_large or self._is_peak_old:
            reset_peak()
            self._before, self._is_peak_old = read_memory("VmRSS"), is_large
        begin = count_cpu_s()
        outcome = self._read(seed, data)
        taken = count_cpu_s() - begin
        grown = max(read_peak() - self._before, 0)
        self._is_peak_old |= grown > NOTED_GROWTH_BYTES
        if taken > MAX_CPU_S or grown > MAX_GROWTH_BYTES:
            self.broken.setdefault(f"{seed.kind}: {taken:.1f} s, {grown >> 20} MiB, {len(data)} bytes", data)
        tally = self.tallies[seed.kind]
        tally.outcomes[outcome] += 1
        tally.cpu_s += taken
        tally.slowest_s, tally.largest_bytes = max(tally.slowest_s, taken), max(tally.largest_bytes, grown)

    def _read(self, seed: Seed, data: bytes) -> str:
        """Return what came of a file."""
        try:
            seed.read(data=data)
        except seed.errors:
            return "refused"
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            self.broken.setdefault(f"{seed.kind}: {type(error).__name__} at {last.filename}:{last.lineno}", data)
            return "other"
        return "read"


def main() -> int:
    """Fuzz for some seconds; print what was found, and return how many files broke the promise, at most 1."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--kinds", help="the readers, separated by commas; by default all")
    parser.add_argument("--seconds", type=float, default=300, help="of a processor")
    parser.add_argument("--seed", type=int, default=time.time_ns() % 2**32)
    parser.add_argument("--keep", type=Path, help="a folder for the files that break a promise")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    limit_memory()
    with make_folder() as folder:
        seeds = list_seeds(Path(folder))
        chosen = [seed for seed in seeds if options.kinds is None or seed.kind in options.kinds.split(",")]
        if not chosen:
            parser.error(f"--kinds: expected some of {','.join(sorted({seed.kind for seed in seeds}))}")
        fuzzer, first = Fuzzer(chosen, options.seed), count_cpu_s()
        while count_cpu_s() - first < options.seconds:
            fuzzer.try_file()
    print(f"seed {options.seed}")
    for kind, tally in sorted(fuzzer.tallies.items()):
        print(f"{kind}: {tally.describe()}")
    for i, (text, data) in enumerate(sorted(fuzzer.broken.items())):
        print(f"BROKEN {text}: {data[:MAX_SHOWN_BYTES]!r}")
        if options.keep is not None:
            options.keep.mkdir(exist_ok=True)
            (options.keep / f"{text.partition(':')[0]}-{options.seed}-{i}").write_bytes(data)
    return min(len(fuzzer.broken), 1)


if __name__ == "__main__":
    sys.exit(main())
