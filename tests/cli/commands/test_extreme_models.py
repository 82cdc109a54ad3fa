"""Models of extreme coordinates: each command draws or writes them, or names the file in one line."""

from pathlib import Path

import pytest

from gpu_xform.cli import main

TRIANGLES: dict[str, list[tuple[float, float, float]]] = {
    "huge": [(1e308, 0, 0), (-1e308, 1, 0), (0, 1e308, 1)],
    "corner": [(1.7e308, 1.7e308, 1.7e308)] * 3,
    "large": [(1e200, 0, 0), (-1e200, 1, 0), (0, 1e200, 1)],
    "beyond_float32": [(1e39, 0, 0), (0, 1e39, 0), (1e39, 1e39, 0)],
    "far": [(1e300, 1e300, 1e300)] * 3,
    "tiny": [(1e-320, 0, 0), (0, 1e-320, 0), (0, 0, 1e-320)],
    "a_point": [(1, 2, 3)] * 3,
}
COMMANDS = {
    "info": "info {}",
    "png": "render {} -o o.png --resolution 48,48",
    "hidden": "render {} -o o.svg --hidden remove --fill face",
    "axes": "render {} -o o.png --axes --labels indices --resolution 96,96",
    "views": "render {} -o o.svg --views front,top",
    "section": "render {} -o o.svg --section 0,0,0,+X",
    "page": "render {} -o o.pdf --paper A4 --drawing-scale 1:2",
    "html": "render {} -o o.html",
    "layer": "render cube.obj -o o.svg --layer {}",
    "stl": "transform {} o.stl --scale 2",
    "glb": "transform {} o.glb",
    "npy": "transform {} o.npy",
    "gif": "animate {} -o o.gif --frames 2 --resolution 32,32",
    "simulate": "simulate {} -o o.gif --duration 0.1 --resolution 32,32",
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", TRIANGLES)
def test_what_cannot_be_drawn_or_written_names_the_file(
    name: str, command: str, working_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = "".join(f"v {x} {y} {z}\n" for x, y, z in TRIANGLES[name])
    (working_folder / f"{name}.obj").write_text(lines + "f 1 2 3\n", "ascii")
    (working_folder / "cube.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n", "ascii")
    code = main(COMMANDS[command].format(f"{name}.obj").split())  # which raises Python's warnings
    printed = capsys.readouterr().err
    errors = [line for line in printed.splitlines() if line.startswith("gpu-xform: error: ")]
    if code == 0:
        assert errors == []
    else:
        assert code == 2
        assert len(errors) == 1
        subject = "cube.obj and 1 more" if command == "layer" and name in ("huge", "corner") else f"{name}.obj"
        assert errors[0].startswith((f"gpu-xform: error: {subject}: ", f"gpu-xform: error: {subject}, transformed: "))
