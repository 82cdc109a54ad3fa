"""`python -m docs.builder [FOLDER]`: build the site, by default into build/site/html, and fail on any flaw."""

import argparse
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as run_sphinx

from .check import find_broken_links
from .command import write_command_page
from .gallery import write_gallery
from .notebook import write_notebook
from .options import write_options
from .pages import Section, write_pages, write_section
from .project import ROOT
from .reference import write_reference

HERE = Path(__file__).parent


def main() -> int:
    """Write the pages, run Sphinx on them, and check the links of what it made."""
    parser = argparse.ArgumentParser(prog="python -m docs.builder", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "build" / "site")
    folder: Path = parser.parse_args().folder
    source, site = folder / "source", folder / "html"
    for old in (source, site):
        shutil.rmtree(old, ignore_errors=True)
    write_source(source)
    strict = ["-W", "--keep-going", "-q", "-j", "auto", "-d", str(folder / "doctrees"), "-E"]
    failed = run_sphinx(["-b", "html", "-c", str(HERE), *strict, str(source), str(site)])
    broken = find_broken_links(site)
    for line in broken:
        print(line, file=sys.stderr)
    if failed or broken:
        return 1
    print(f"wrote {site / 'index.html'}")
    return 0


def write_source(source: Path) -> None:
    """Write all pages of the site, as Sphinx reads them, into a folder."""
    shutil.copytree(HERE / "pages", source)
    shutil.copytree(ROOT / "docs" / "images", source / "images")
    write_pages(source)
    tutorials = ("ci", "lidar", "teaching", "robotics", "illustration", "lecture")
    words = "A page per kind of user; the tests run their commands. The last one is a notebook, with what it puts out."
    write_section(source, Section("tutorials", "Tutorials", words, tutorials))
    guides = tuple(sorted(page.stem for page in (source / "guides").glob("*.md")))
    write_section(source, Section("guides", "Guides", "One subject each. The tests run the examples.", guides))
    write_reference(source)
    write_command_page(source)
    write_gallery(source)
    write_options(source)
    write_notebook(source)
    about = ("benchmarks", "reliability", "changelog", "contributing", "architecture", "releasing", "security")
    write_section(source, Section("project", "Project", "How it is measured, tested, built and changed.", about))


if __name__ == "__main__":
    sys.exit(main())
