"""Pictures without and with each option of `gpu-xform render`, made by the command itself."""

import contextlib
import io
import os
import shlex
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import gpu_xform as gx
from gpu_xform.cli import main as run_command

from .command import describe_commands, escape
from .pages import write

SIZE = "320,240"

# A line per option: what is drawn without it, and what the option adds to that. The models are those of `write_models`.
PLAIN: dict[str, tuple[str, str]] = {
    "--scale": ("house.obj --camera-position 5,3,8", "--scale 1,2,1"),
    "--rotate-x": ("house.obj", "--rotate-x 40"),
    "--rotate-y": ("house.obj", "--rotate-y 40"),
    "--rotate-z": ("house.obj", "--rotate-z 40"),
    "--rotate": ("house.obj", "--rotate 1,1,0,60"),
    "--translate": ("house.obj --camera-position 3,3,9 --camera-focal-point 0,0,0", "--translate 1,0.5,0"),
    "--shear": ("house.obj", "--shear xy=0.6"),
    "--reflect": ("arrow.obj --camera-position 3,3,9 --camera-focal-point 0,0,0", "--reflect 1,0,0"),
    "--project-onto": ("house.obj", "--project-onto 0,1,0"),
    "--perspective-from-eye": ("house.obj --camera-orthographic", "--perspective-from-eye 4"),
    "--matrix": ("house.obj", "--matrix 1,0,0,0,0.4,1,0,0,0,0,1,0,0,0,0,1"),
    "--edges": ("part.obj", "--edges feature,silhouette"),
    "--feature-angle": ("hills.obj --edges feature", "--feature-angle 8"),
    "--hidden": ("house.obj", "--hidden dash"),
    "--hidden-style": ("house.obj --hidden dash", "--hidden-style 'color=tomato;line-width=1;dash=dashed'"),
    "--line-width": ("house.obj", "--line-width 4"),
    "--dash": ("house.obj --line-width 2", "--dash long-dashed-dotted"),
    "--point-size": ("house.obj", "--point-size 9"),
    "--max-points": ("cloud.npy", "--max-points 2000"),
    "--fill": ("part.obj", "--fill gold"),
    "--shading": ("part.obj --fill lightsteelblue --edges feature,silhouette", "--shading flat"),
    "--color": ("ball.obj --hidden remove --line-width 2", "--color face"),
    "--scalars": ("hills.obj --hidden remove", "--scalars y"),
    "--face-colors": ("house.obj --line-width 3", "--face-colors faces.npy"),
    "--edge-colors": ("house.obj --line-width 3", "--edge-colors edges.npy"),
    "--vertex-colors": ("house.obj --line-width 3", "--vertex-colors points.npy"),
    "--cmap": ("hills.obj --scalars y --fill white", "--cmap plasma"),
    "--clim": ("hills.obj --scalars y --fill white", "--clim 0,0.5"),
    "--section": ("part.obj --fill wheat --edges feature,silhouette", "--section 0,0,0,0.3,0.2,1"),
    "--hatch": ("part.obj --fill wheat --edges feature,silhouette --section 0,0,0,0.3,0.2,1", "--hatch auto"),
    "--alpha": ("part.obj --fill steelblue", "--alpha 0.4"),
    "--labels": ("house.obj", "--labels indices"),
    "--depth-cue": ("ball.obj --line-width 2", "--depth-cue 0.9"),
    "--no-antialias": ("ball.obj", "--no-antialias"),
    "--colorbar": ("hills.obj --scalars y --hidden remove", "--colorbar"),
    "--instances": ("house.obj --hidden remove", "--instances places.npy"),
    "--layer": ("house.obj --hidden remove", "--layer 'ball.obj --translate 3,0,0 --fill gold'"),
    "--background-color": ("house.obj", "--background-color aliceblue"),
    "--no-background": ("house.obj", "--no-background"),
    "--axes": ("hills.obj --hidden remove", "--axes"),
    "--axis-titles": ("hills.obj --hidden remove --axes", "--axis-titles east,height,north"),
    "--legend": ("house.obj --layer 'ball.obj --translate 3,0,0 --color tomato'", "--legend"),
    "--font-size": ("house.obj --labels indices", "--font-size 18"),
    "--up": ("hills_z.obj --hidden remove", "--up +Z"),
    "--camera-direction": ("house.obj --hidden remove", "--camera-direction -Z"),
    "--camera-position": ("house.obj --hidden remove", "--camera-position 4,-2,6"),
    "--camera-focal-point": ("house.obj --camera-position 4,2,6", "--camera-focal-point 1,1,0"),
    "--camera-view-up": ("house.obj --hidden remove", "--camera-view-up 1,1,0"),
    "--camera-view-angle": ("house.obj --camera-position 2,2,4", "--camera-view-angle 70"),
    "--camera-orthographic": ("house.obj", "--camera-orthographic"),
    "--camera-azimuth-angle": ("house.obj --hidden remove", "--camera-azimuth-angle 40"),
    "--camera-elevation-angle": ("house.obj --hidden remove", "--camera-elevation-angle 40"),
    "--camera-zoom-factor": ("house.obj --hidden remove", "--camera-zoom-factor 0.5"),
    "--views": ("part.obj --edges feature,silhouette", "--views front,top,right,iso"),
    "--projection": ("part.obj --edges feature,silhouette --views front,top,right", "--projection first"),
    "--paper": ("house.obj", "--paper 85x60mm"),
    "--drawing-scale": ("house.obj --paper 85x60mm --units cm", "--drawing-scale 1:1"),
    "--margin": ("house.obj --paper 85x60mm", "--margin 20mm"),
    "--units": ("house.obj --paper 85x60mm --drawing-scale 1:1 --units cm", "--units mm"),
    "--dpi": ("house.obj --line-width 0.5mm", "--dpi 250"),
    "--pose": ("arm.urdf --up +Z --hidden remove", "--pose elbow=60deg"),
    "--parts": ("arm.urdf --up +Z --hidden remove --labels names", "--parts"),
    "--tolerance": ("curved.obj --hidden remove", "--tolerance 0.3"),
}

# Options that change no picture of theirs, and why.
UNSEEN = {
    "--font": "which fonts there are differs from machine to machine",
    "--adapter": "pictures of two adapters differ by a rounding",
    "--file-limits": "refuses files",
    "--file-type": "names the type of the input",
    "--isolated": "reads files in a process of its own",
    "--output": "names the picture",
    "--rasterizer": "pictures of both differ by at most 2/255",
    "--reference": "compares",
    "--reference-diff": "compares",
    "--reference-pixels": "compares",
    "--reference-threshold": "compares",
    "--report": "writes a report",
    "--max-edges": "makes a web page smaller",
    "--title": "names a web page",
    "--resolution": "the size in pixels",
    "--sheet": "lays all models out on a contact sheet",
    "--update-references": "writes references",
    "--help": "prints help",
    "--verbose": "prints what is done",
}


# A robot of two boxes and the joint between them.
ARM = """\
<robot name="arm">
  <link name="upper"><visual><origin xyz="0 0 0.5"/><geometry><box size="0.2 0.2 1"/></geometry></visual></link>
  <link name="lower"><visual><origin xyz="0 0 0.4"/><geometry><box size="0.14 0.14 0.8"/></geometry></visual></link>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def write_models(folder: Path) -> None:
    """Write the models and arrays that the commands of this page name."""
    gx.save_mesh(gx.samples.house(), folder / "house.obj")
    gx.save_mesh(gx.samples.snub_dodecahedron(), folder / "ball.obj")
    gx.save_mesh(gx.samples.torus(40, 20), folder / "part.obj")
    arrow = [(0, 0, 0), (1.6, 0, 0), (1.6, 0.5, 0), (2.4, -0.2, 0), (1.6, -0.9, 0), (1.6, -0.4, 0), (0, -0.4, 0)]
    gx.save_mesh(gx.Mesh(arrow, [range(7)]), folder / "arrow.obj")
    hills = gx.parametric(
        lambda x, z: (x, np.exp(-(x**2) - z**2) + 0.5 * np.exp(-2 * ((x - 1.4) ** 2 + (z + 1) ** 2)), z),
        (-2.2, 2.2),
        (-2.2, 2.2),
        closed=(False, False),
        n=(26, 26),
    )
    gx.save_mesh(hills, folder / "hills.obj")
    gx.save_mesh(hills.transformed(gx.rotate_x(90, degrees=True)), folder / "hills_z.obj")
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(40_000, 3))
    np.save(folder / "cloud.npy", ball / np.linalg.norm(ball, axis=1, keepdims=True))
    cycle = np.array([(0.12, 0.47, 0.71), (0.84, 0.15, 0.16), (0.17, 0.63, 0.17), (1.0, 0.5, 0.05)])
    house = gx.samples.house()
    for name, count in (("faces", house.n_faces), ("edges", len(house.edges)), ("points", house.n_points)):
        np.save(folder / f"{name}.npy", cycle[np.arange(count) % 4])
    np.save(folder / "places.npy", np.array([gx.translate(2.6 * k, 0, -1.5 * k) for k in range(4)]))
    (folder / "curved.obj").write_text(_curved_sheet(), "utf-8")
    (folder / "arm.urdf").write_text(ARM, "utf-8")


def _curved_sheet() -> str:
    """Return an OBJ file of one Bézier patch."""
    points = [(x, 0.9 * (x - 1.5) ** 2 - 0.7 * (y - 1.5) ** 2, y) for y in range(4) for x in range(4)]
    corners = " ".join(str(k + 1) for k in range(16))
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    knots = ["parm u 0 1", "parm v 0 1"]
    return "\n".join([*lines, "cstype bezier", "deg 3 3", f"surf 0 1 0 1 {corners}", *knots, "end", ""])


def write_options(source: Path) -> None:
    """Write the page, and its pictures."""
    folder = source / "options"
    folder.mkdir(parents=True)
    helps = _read_helps()
    shown = [
        "# Each option, before and after",
        "",
        "All pictures are made by these commands when this site is built.",
        "",
    ]
    with _run_in(folder):
        write_models(Path())
        for option, (models, addition) in PLAIN.items():
            name = option.lstrip("-")
            draw(f"{models}", f"{name}_without.png")
            draw(f"{models} {addition}", f"{name}_with.png")
            shown += [
                f"## `{option}`\n\n{helps[option]}\n\n::::{{grid}} 2\n:gutter: 2\n",
                f":::{{grid-item}}\n![without {option}]({name}_without.png)\n\n`gpu-xform render {models}`\n:::\n",
                f":::{{grid-item}}\n![with {option}]({name}_with.png)\n\n`... {addition}`\n:::\n::::\n",
            ]
    shown.append("## Options that change no picture here\n\n| option | what it does |\n|---|---|")
    shown += [f"| `{option}` | {words} |" for option, words in UNSEEN.items()]
    write(folder / "index.md", "\n".join(shown) + "\n")


def _read_helps() -> dict[str, str]:
    """Return what the command says of each option, as a sentence."""
    [render] = [command for command in describe_commands() if command.name == "render"]
    options = [option for _, group in render.groups for option in group]
    return {option.typed.split()[0]: escape(option.words[0].upper() + option.words[1:]) + "." for option in options}


def draw(arguments: str, picture: str) -> None:
    """Run `gpu-xform render` in this process, in the folder that it is in; raise if it does not end well."""
    words = shlex.split(arguments)
    size = [] if "--paper" in words else ["--resolution", SIZE]
    messages = io.StringIO()
    with contextlib.redirect_stderr(messages):
        code = run_command(["render", *words, *size, "-o", picture])
    if code or messages.getvalue():
        raise RuntimeError(f"gpu-xform render {arguments}: exit code {code}\n{messages.getvalue()}")


@contextlib.contextmanager
def _run_in(folder: Path) -> Iterator[None]:
    """Run in a folder."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
