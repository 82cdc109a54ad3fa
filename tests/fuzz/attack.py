"""Signals at random moments in the command: nothing lost, nothing half, right exit codes. `make attack MOMENTS=200`.

It needs /proc, as Linux has it.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

import gpu_xform as gx

SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGKILL: -9}
N_POINTS = 4_000_000
COMMANDS = {
    "transform": (["transform", "in.npy", "out.npy", "--scale", "2"], "out.npy"),
    "render": (["render", "model.obj", "-o", "out.png", "--resolution", "512,512"], "out.png"),
    "animate": (["animate", "model.obj", "-o", "out.gif", "--frames", "20", "--resolution", "128,128"], "out.gif"),
}
_SIGTERM_BIT = 1 << (signal.SIGTERM - 1)


def main() -> int:
    """Interrupt commands at random moments; print a table, and return how many promises were broken."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--moments", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = random.Random(options.seed)  # noqa: S311 - no secret
    broken: list[str] = []
    outcomes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        np.save("in.npy", np.ones((N_POINTS, 3), np.float32))
        gx.save_mesh(gx.samples.icosphere(4), "model.obj")
        whole, took = {}, {}
        for name, (typed, file) in COMMANDS.items():
            begin = time.monotonic()
            subprocess.run([sys.executable, "-m", "gpu_xform", *typed], check=True)
            took[name], whole[name] = time.monotonic() - begin, Path(file).read_bytes()
        given = set(os.listdir())  # noqa: PTH208
        for _ in range(options.moments):
            name, number = rng.choice(list(COMMANDS)), rng.choice(list(SIGNALS))
            typed, file = COMMANDS[name]
            Path(file).write_bytes(b"the old file")
            process = subprocess.Popen([sys.executable, "-m", "gpu_xform", *typed], stderr=subprocess.PIPE)
            await_handlers(process)
            time.sleep(rng.uniform(0.0, 1.1 * took[name]))
            process.send_signal(number)
            _, printed = process.communicate()
            content, what = Path(file).read_bytes(), f"{name} by {number.name}"
            left = {path for path in os.listdir() if path not in given and ".partial" not in path}  # noqa: PTH208
            if content not in (b"the old file", whole[name]):
                broken.append(f"{what}: half a file")
            if process.returncode not in (0, SIGNALS[number]):
                broken.append(f"{what}: exit code {process.returncode}: {printed[-200:]!r}")
            if left and number != signal.SIGKILL:
                broken.append(f"{what}: left {left}")
            if printed.count(b"\n") > 1:
                broken.append(f"{what}: printed {printed[-300:]!r}")
            for path in left:
                Path(path).unlink()
            if name == "transform" and process.returncode != 0:
                again = [sys.executable, "-m", "gpu_xform", *typed, "--resume"]
                if subprocess.run(again, check=False).returncode or Path(file).read_bytes() != whole[name]:
                    broken.append(f"{what}: not resumed")
            outcomes[f"{what}: {process.returncode}"] += 1
        os.chdir("/")
    for outcome, count in sorted(outcomes.items()):
        print(f"{outcome:32} {count}")
    for line in broken:
        print(f"BROKEN {line}")
    return min(len(broken), 1)


def await_handlers(process: subprocess.Popen[bytes]) -> None:
    """Wait until the command handles signals: before, Python can only print a traceback of its own start."""
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        caught = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt:"))
        if int(caught.split()[1], 16) & _SIGTERM_BIT:
            return
        time.sleep(0.001)


if __name__ == "__main__":
    sys.exit(main())
