"""What is freed goes back to the system."""

from gpu_xform._core.allocator import give_back_memory
from tests.support.python_run import linux_only, python_output

PROGRAM = """
import os
from pathlib import Path
from gpu_xform._core.allocator import give_back_memory

def measure():
    return int(Path("/proc/self/statm").read_text("ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")

blocks = [b"1" * 100_000 for _ in range(1_000)]  # 100 MB
last = blocks[-1]
del blocks
kept = measure()
give_back_memory()
print(kept - measure())
"""


def test_a_process_can_always_ask() -> None:
    give_back_memory()


@linux_only
def test_free_blocks_below_one_in_use_are_given_back() -> None:
    assert int(python_output(PROGRAM)) > 90_000_000
