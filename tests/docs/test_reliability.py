"""The page about reliability: its example runs, and what it names is there."""

import re
from pathlib import Path

import gpu_xform as gx
from gpu_xform.formats import isolation, limits

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reliability.md").read_text("utf-8")


def test_the_example_reads_a_model_of_a_stranger(working_folder: Path) -> None:  # noqa: ARG001
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    gx.save_mesh(gx.samples.house(), "house.obj")
    names = {"gx": gx, "path": "house.obj"}
    exec(code, names)  # noqa: S102 - our own page
    assert names["mesh"] == gx.samples.house()


def test_tests_and_targets_that_it_names_are_there() -> None:
    tests = re.findall(r"`(tests/[\w/]+\.py)`", PAGE)
    assert len(tests) > 15
    assert [name for name in tests if not (ROOT / name).exists()] == []
    targets = set(re.findall(r"`make ([a-z-]+)", PAGE))
    assert targets >= {"attack", "fuzz", "soak", "test"}
    text = (ROOT / "Makefile").read_text("utf-8")
    assert {name for name in targets if f"\n{name}:" not in text} == set()


def test_defaults_are_those_of_the_readers() -> None:
    numbers = f"{limits.FREE_NUMBERS // 10**6} million numbers and {limits.NUMBERS_PER_BYTE} per byte of the file"
    nodes = f"{limits.FREE_NODES:,} nodes and {limits.NODES_PER_NODE} per node"
    time = f"{isolation.DEFAULT_CPU_S:g} s of a processor, and twice as many and 30 s by the clock"
    memory = f"{isolation.DEFAULT_MEMORY_BYTES >> 30} GiB"
    for words in (numbers, nodes, f"{limits.FREE_BYTES >> 20} MiB and 40 to 100 bytes", time, memory):
        assert words in PAGE
