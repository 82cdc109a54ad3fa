"""Settings of Sphinx."""

import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

sys.path.insert(0, str(Path(__file__).parents[2]))

import gpu_xform
from docs.builder.project import REPOSITORY, SITE
from docs.builder.reference import drop_reading_order

project = "gpu_xform"
author = "the gpu_xform maintainers"
copyright = f"2026 {author}"  # noqa: A001 - Sphinx reads this name
version = release = gpu_xform.__version__

extensions = ["myst_nb", "numpydoc", "sphinx.ext.autodoc", "sphinx_copybutton", "sphinx_design"]
nitpicky = True
# In docstrings single quotes are around names, of which some are no public objects; types are written for people.
default_role = "py:obj"
smartquotes = False
nitpick_ignore_regex = [("py:obj", r".*"), ("py:class", r".*"), ("py:data", r".*")]

myst_enable_extensions = ["attrs_inline", "attrs_block", "colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # docs/builder/notebook.py runs it

autodoc_typehints = "none"  # in signatures, NumPy's types would take pages; the parameters below tell theirs
autodoc_member_order = "bysource"
python_maximum_signature_line_length = 100
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_theme = "pydata_sphinx_theme"
html_title = "gpu_xform"
html_baseurl = SITE
html_static_path = ["static"]
html_css_files = ["site.css"]
html_logo = "static/logo.svg"
html_favicon = "static/logo.svg"
html_copy_source = False
html_show_sourcelink = False
html_math_renderer = "mathml"
html_context = {"default_mode": "auto"}
html_theme_options: dict[str, Any] = {
    "logo": {"text": "gpu_xform"},
    "icon_links": [{"name": "Repository", "url": REPOSITORY, "icon": "fa-brands fa-github"}],
    "navbar_align": "left",
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "header_links_before_dropdown": 7,
}
html_sidebars: dict[str, list[str]] = {"index": [], "gallery/index": [], "options/index": [], "start": []}


def _write_math(translator: Any, node: nodes.Element) -> None:
    """Write a formula as MathML, which browsers show without a script."""
    is_block = isinstance(node, nodes.math_block)
    mathml = tex2mathml(node.astext(), as_block=is_block)
    translator.body.append(f'<div class="math">{mathml}</div>' if is_block else mathml)
    raise nodes.SkipNode


def _escape_bars(_app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Keep |x| of docstrings, which is no substitution, as it is."""
    lines[:] = ["``".join(_escape_outside(line.split("``"))) for line in lines]


def _escape_outside(parts: list[str]) -> list[str]:
    return [part if k % 2 else part.replace("|", r"\|") for k, part in enumerate(parts)]


def _drop_order(_app: Any, what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Leave out the reading order of a folder, which is for those who read the source."""
    if what == "module":
        lines[:] = drop_reading_order(lines)


def setup(app: Any) -> None:
    """Register the formulas, and what becomes of docstrings."""
    app.connect("autodoc-process-docstring", _escape_bars)
    app.connect("autodoc-process-docstring", _drop_order)
    app.add_html_math_renderer("mathml", (_write_math, None), (_write_math, None))
