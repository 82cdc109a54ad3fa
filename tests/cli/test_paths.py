"""Patterns in paths."""

from pathlib import Path

from gpu_xform import samples, save_mesh
from gpu_xform.cli import main, paths
from tests.support.cli import list_pngs

SIZE = ("--resolution", "60,40")


def test_patterns_that_no_shell_has_expanded() -> None:
    Path("in/deep").mkdir(parents=True)
    for name in ("in/b.obj", "in/deep/a.obj", "in/x1.obj", "in/x[1].obj"):
        save_mesh(samples.cube(), name)
    assert paths.expand_globs(["in/*.obj"]) == ["in/b.obj", "in/x1.obj", "in/x[1].obj"]
    assert paths.expand_globs(["in/**/*.obj"]) == ["in/b.obj", "in/deep/a.obj", "in/x1.obj", "in/x[1].obj"]
    assert paths.expand_globs(["in/x[1].obj"]) == ["in/x[1].obj"]
    assert paths.expand_globs(["in/x[12].obj"]) == ["in/x1.obj"]
    assert paths.expand_globs(["in/*.wrl"]) == ["in/*.wrl"]
    assert paths.expand_globs(["-"]) == ["-"]
    assert main(["render", "in/*.obj", "-o", "{model}.png", *SIZE]) == 0
    assert list_pngs() == ["b.png", "x1.png", "x[1].png"]
