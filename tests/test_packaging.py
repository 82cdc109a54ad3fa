"""What a release is made of: the metadata, the recipe and the workflows agree, and PyPI's page has whole addresses."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hatchling.metadata.core import ProjectMetadata
from hatchling.plugin.manager import PluginManager

import gpu_xform

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
RECIPE = (ROOT / "packaging" / "conda-forge" / "recipe.yaml").read_text("utf-8")
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
CONDA_NAMES = {"wgpu": "wgpu-py"}


@pytest.fixture(scope="module")
def metadata() -> Any:
    manager: Any = PluginManager
    return ProjectMetadata(str(ROOT), manager()).core


def test_links_and_pictures_of_the_page_on_pypi_are_addresses_of_the_tag(metadata: Any) -> None:
    page = metadata.readme
    targets = re.findall(r'\]\(([^)\s]+)\)|src="([^"]+)"', page)
    assert len(targets) > 20
    for target in map("".join, targets):
        assert re.match(r"https://|#", target), target
        path = re.fullmatch(r"https://[^/]+/gpu-xform/gpu_xform/(?:blob/)?v([\d.]+)/([^#]+).*", target)
        if path is not None:
            assert path[1] == gpu_xform.__version__
            assert (ROOT / path[2]).exists(), target
    pictures = [target for _, target in targets if target]
    assert len(pictures) == 3
    assert all(target.startswith("https://raw.githubusercontent.com/") for target in pictures)


def test_the_metadata_names_authors_and_addresses(metadata: Any) -> None:
    assert {"Documentation", "Repository", "Issues", "Changelog"} <= set(metadata.urls)
    assert metadata.authors == [{"name": "the gpu_xform maintainers"}]
    repository = PROJECT["urls"]["Repository"]
    settings = (ROOT / "pyproject.toml").read_text("utf-8")
    assert f"{repository}/blob/v$HFPR_VERSION/" in settings
    assert f"{repository.replace('github.com', 'raw.githubusercontent.com')}/v$HFPR_VERSION/" in settings


def test_the_extra_all_is_every_extra_of_users() -> None:
    extras = PROJECT["optional-dependencies"]
    [everything] = extras["all"]
    named = re.fullmatch(r"gpu_xform\[(.+)\]", everything)
    assert named is not None
    assert set(named[1].split(",")) == set(extras) - {"all", "bench", "dev", "docs"}


def test_the_recipe_requires_what_the_package_requires() -> None:
    run = RECIPE.split("  run:\n")[1].split("\ntests:")[0]
    listed = dict(re.findall(r"^    - (\S+) (\S+)$", run, re.MULTILINE))
    assert listed.pop("python", ">=") == ">="  # its version is a variable of the recipe
    required = dict(re.findall(r"^([\w-]+)(.*)$", "\n".join(PROJECT["dependencies"]), re.MULTILINE))
    assert listed == {CONDA_NAMES.get(name, name): versions for name, versions in required.items()}
    assert f'version: "{gpu_xform.__version__}"' in RECIPE
    assert f'python_min: "{PROJECT["requires-python"].removeprefix(">=")}"' in RECIPE
    assert "gpu-xform = gpu_xform_command:main" in RECIPE


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_actions_are_pinned_by_the_hash_of_a_commit(path: Path) -> None:
    used = re.findall(r"uses: (\S+)(.*)$", path.read_text("utf-8"), re.MULTILINE)
    assert used
    for action, remark in used:
        assert action.startswith("./") or re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", action), action
        assert action.startswith("./") or re.fullmatch(r" # v[\d.]+", remark), action


def test_a_release_is_tested_before_it_is_published() -> None:
    release = (ROOT / ".github" / "workflows" / "release.yml").read_text("utf-8")
    assert re.search(r'on:\n  push:\n    tags: \["v\*"\]', release)
    assert re.search(r"  test:\n(?:.*\n)*?    needs: build\n", release)
    publish = release.split("\n  publish:\n")[1]
    assert "needs: test" in publish
    assert "id-token: write" in publish
    assert "password" not in publish
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    for workflow in WORKFLOWS:
        for line in re.findall(r"run: make (.+)$", workflow.read_text("utf-8"), re.MULTILINE):
            assert set(re.sub(r"\w+=.*", "", line).split()) <= targets, line
