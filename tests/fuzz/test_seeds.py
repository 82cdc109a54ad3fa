"""Every reader is fuzzed, from files that are right."""

import warnings
from pathlib import Path

from gpu_xform.chunked.registry import SOURCES
from gpu_xform.errors import MeshWarning
from gpu_xform.formats.registry import READERS
from tests.fuzz.seeds import SAME_AS, list_seeds


def test_every_type_that_is_read_is_fuzzed_from_files_that_are_right(tmp_path: Path) -> None:
    seeds = list_seeds(tmp_path)
    read = {*READERS, *(f"chunked-{kind}" for kind in SOURCES), "mtl"}
    assert {seed.kind for seed in seeds} | {*SAME_AS} == read
    with warnings.catch_warnings(action="ignore", category=MeshWarning):
        for seed in {seed.kind: seed for seed in seeds if seed.kind != "step"}.values():  # which takes half a second
            seed.read(data=seed.data)
