"""The program of pages: stages within WebGPU's limits, and scripts that fit together."""

import re

import pytest

from gpu_xform.gpu.wgsl import installed_sources
from gpu_xform.web import program

MAX_STORAGE_BUFFERS = 8  # per shader stage, WebGPU's default
STORAGE = re.compile(r"^@group\(0\) @binding\(\d+\) var<storage", re.MULTILINE)
NAME = re.compile(r"^(?:export )?(?:async )?(?:function\*?|const|class|let) (\w+)", re.MULTILINE)
IMPORT = re.compile(r'^import \{([^}]*)\} from "\./(\w+)\.js";', re.MULTILINE)
SCRIPTS = {name: program.read_script(name) for name in program.SCRIPTS}


@pytest.mark.parametrize("stage", program.STAGES)
def test_no_stage_binds_more_storage_buffers_than_any_device_takes(stage: str) -> None:
    source = installed_sources().source(stage, "f32" if stage == "vertex_transform" else None)
    assert 0 < len(STORAGE.findall(source.code)) <= MAX_STORAGE_BUFFERS


def test_no_two_scripts_define_the_same_name() -> None:
    names = [name for text in SCRIPTS.values() for name in NAME.findall(text)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("script", program.SCRIPTS)
def test_scripts_import_names_that_earlier_ones_export(script: str) -> None:
    earlier = program.SCRIPTS[: program.SCRIPTS.index(script)]
    for names, other in IMPORT.findall(SCRIPTS[script]):
        assert other in earlier
        for name in re.findall(r"\w+", names):
            assert re.search(rf"^export (?:async )?(?:function|const|class) {name}\b", SCRIPTS[other], re.MULTILINE)
            assert len(re.findall(rf"\b{name}\b", SCRIPTS[script])) > 1


def test_joined_scripts_are_one_module() -> None:
    joined = program.join_scripts()
    assert not re.search(r"^\s*(import|export)", joined, re.MULTILINE)
    assert "function openPage" in joined


def test_the_layout_of_a_struct_names_offsets_and_types() -> None:
    style = program.describe_program()["layouts"]["LINE_STYLE"]
    assert style["size"] == 128
    assert style["fields"]["color"] == {"offset": 16, "type": "Float32"}
    assert style["fields"]["n_edges"] == {"offset": 40, "type": "Uint32"}
    assert style["fields"]["depth_cue"]["fields"]["amount"] == {"offset": 12, "type": "Float32"}
