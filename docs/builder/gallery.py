"""The gallery: each script of examples/gallery is run, and has a page with its picture and its code."""

import ast
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from PIL import Image

from .pages import write
from .project import ROOT

SCRIPTS = ROOT / "examples" / "gallery"
THUMBNAIL_PX = (480, 340)
FIRST = ("teapot", "scarf", "terrain_scan", "flange", "snub_dodecahedron", "city")  # what a visitor sees first
N_PROCESSES = 2  # a picture keeps several processors busy by itself


def write_gallery(source: Path) -> None:
    """Run all scripts, and write a page for each, and one that shows them all."""
    folder = source / "gallery"
    folder.mkdir(parents=True)
    scripts = sorted(SCRIPTS.glob("*.py"), key=lambda script: (_rank(script.stem), script.stem))
    with ThreadPoolExecutor(N_PROCESSES) as pool:
        pictures = list(pool.map(lambda script: run_script(script, folder), scripts))
    cards = []
    for script, picture in zip(scripts, pictures, strict=True):
        title, words, code = read_script(script)
        write(
            folder / f"{script.stem}.md",
            f"# {title}\n\n{words}\n\n![{title}]({picture.name})\n\n```python\n{code}```\n\n"
            f"`python examples/gallery/{script.name}` writes `{picture.name}`.\n",
        )
        thumbnail = make_thumbnail(picture)
        cards.append(
            f":::{{grid-item-card}} {title}\n:link: {script.stem}\n:link-type: doc\n"
            f":img-top: {thumbnail.name}\n:img-alt: {title}\n:::\n"
        )
    names = "\n".join(script.stem for script in scripts)
    write(
        folder / "index.md",
        f"# Gallery\n\n{len(scripts)} pictures, each made by a short script when this site is built. A click shows the "
        f"script.\n\n::::{{grid}} 1 2 3 3\n:gutter: 3\n:class-container: gallery\n\n{''.join(cards)}::::\n\n"
        f"```{{toctree}}\n:hidden:\n\n{names}\n```\n",
    )


def _rank(name: str) -> int:
    return FIRST.index(name) if name in FIRST else len(FIRST)


def run_script(script: Path, folder: Path) -> Path:
    """Run a script in a folder, and return the picture that it wrote; warnings are errors."""
    ran = subprocess.run(
        [sys.executable, "-W", "error", script], cwd=folder, capture_output=True, text=True, env=os.environ, check=False
    )
    if ran.returncode:
        raise RuntimeError(f"{script.name} failed:\n{ran.stderr}")
    [picture] = (path for path in folder.glob(f"{script.stem}.*") if path.suffix in (".png", ".webp", ".svg"))
    return picture


def read_script(script: Path) -> tuple[str, str, str]:
    """Return the title, the description and the code of a script."""
    text = script.read_text("utf-8")
    docstring = ast.get_docstring(ast.parse(text))
    if docstring is None or "\n\n" not in docstring:
        raise ValueError(f"{script.name}: its docstring must be a title, an empty line and a description")
    title, _, words = docstring.partition("\n\n")
    return title.removesuffix("."), words, text.split('"""', 2)[2].lstrip("\n")


def make_thumbnail(picture: Path) -> Path:
    """Write a smaller picture of the same shape for all, and return its path; an animation stays one."""
    path = picture.with_name(f"{picture.stem}_small{picture.suffix}")
    if picture.suffix == ".webp":
        path.write_bytes(picture.read_bytes())
        return path
    with Image.open(picture) as image:
        small = image.convert("RGB")
        background = small.getpixel((0, 0))
        small.thumbnail(THUMBNAIL_PX, Image.Resampling.LANCZOS)
    framed = Image.new("RGB", THUMBNAIL_PX, background)
    framed.paste(small, ((THUMBNAIL_PX[0] - small.width) // 2, (THUMBNAIL_PX[1] - small.height) // 2))
    framed.save(path, optimize=True)
    return path
