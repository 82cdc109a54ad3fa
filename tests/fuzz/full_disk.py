"""Commands onto a disk that is full before they are done: the old file stays, and the next run works. `make attack`.

The disk is a tmpfs of a random size in a namespace of its own, which takes no rights where the kernel lets users have
one; elsewhere this says so, and passes.
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import gpu_xform as gx
from gpu_xform.cli.exit_codes import WRONG_INPUT

N_POINTS = 400_000
COMMANDS = {
    "transform": (["transform", "in.npy", "disk/out.npy", "--scale", "2"], "out.npy"),
    "render": (["render", "model.obj", "-o", "disk/out.png", "--resolution", "256,256"], "out.png"),
    "svg": (["render", "model.obj", "-o", "disk/out.svg"], "out.svg"),
    "animate": (["animate", "model.obj", "-o", "disk/out.gif", "--frames", "8", "--resolution", "96,96"], "out.gif"),
}
OLD = b"the old file"
PAGE_BYTES = 4096  # of which a tmpfs is made
LARGE = "64m"


def run(typed: list[str]) -> tuple[int, bytes]:
    """Run a command; return its exit code, and what it printed on standard error."""
    ran = subprocess.run([sys.executable, "-m", "gpu_xform", *typed], stderr=subprocess.PIPE, check=False)
    return ran.returncode, ran.stderr


def mount(size: str, *, again: bool = False) -> None:
    """Mount `disk`, empty and of a size, or give it another one."""
    options = f"remount,size={size}" if again else f"size={size}"
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", "disk"], check=True)  # noqa: S607


def attack(options: argparse.Namespace) -> int:
    """Fill disks, in a namespace that has the right to mount them; return how many promises were broken, at most 1."""
    rng = random.Random(options.seed)  # noqa: S311 - no secret
    np.save("in.npy", np.ones((N_POINTS, 3), np.float32))
    gx.save_mesh(gx.samples.icosphere(3), "model.obj")
    disk = Path("disk")
    disk.mkdir()
    mount(LARGE)
    whole = {}
    for name, (typed, file) in COMMANDS.items():
        assert run(typed) == (0, b"")
        whole[name] = (disk / file).read_bytes()
    broken: list[str] = []
    outcomes: Counter[str] = Counter()
    for _ in range(options.moments):
        name = rng.choice(list(COMMANDS))
        typed, file = COMMANDS[name]
        # A page for the old file, and less than the new one takes.
        n_pages = rng.randrange(1, max(len(whole[name]) // PAGE_BYTES, 2)) + 1
        subprocess.run(["umount", "disk"], check=True)  # noqa: S607
        mount(str(n_pages * PAGE_BYTES))
        (disk / file).write_bytes(OLD)
        code, printed = run(typed)
        what = f"{name} on {n_pages} pages"
        left = [path.name for path in disk.iterdir() if path.name != file and ".partial" not in path.name]
        if (disk / file).read_bytes() != OLD:
            broken.append(f"{what}: the old file is gone")
        if code != WRONG_INPUT or printed.count(b"\n") != 1:
            broken.append(f"{what}: exit code {code}: {printed[-300:]!r}")
        if left:
            broken.append(f"{what}: left {left}")
        mount(LARGE, again=True)
        code, printed = run([*typed, *(["--resume"] if name == "transform" else [])])
        if code or (disk / file).read_bytes() != whole[name]:
            broken.append(f"{what}: with room again: exit code {code}: {printed[-300:]!r}")
        outcomes[name] += 1
    for name, count in sorted(outcomes.items()):
        print(f"full disk under {name:24} {count}")
    for line in broken:
        print(f"BROKEN {line}")
    return min(len(broken), 1)


def main() -> int:
    """Go into a namespace and fill disks there; return how many promises were broken, at most 1."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--moments", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--inside", help="the folder to work in, in a namespace of its own")
    options = parser.parse_args()
    if options.inside:
        os.chdir(options.inside)
        return attack(options)
    unshare = ["unshare", "--user", "--map-root-user", "--mount"]
    try:
        subprocess.run([*unshare, "true"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"full disk: left out, for no namespace may be made here: {error}")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        typed = [sys.executable, "-m", "tests.fuzz.full_disk", "--inside", folder]
        return subprocess.run(
            [*unshare, *typed, "--moments", str(options.moments), "--seed", str(options.seed)], check=False
        ).returncode


if __name__ == "__main__":
    sys.exit(main())
