"""Sphinx's configuration: ``./run docs`` builds the site into docs/_build/html, without a network."""

from __future__ import annotations

import re
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pyvista
from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.errors import ExtensionError

pyvista.OFF_SCREEN = True
pyvista.BUILDING_GALLERY = True

project = "vtksmooth"
author = copyright = "The vtksmooth developers"
release = version = version("vtksmooth")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["_build"]
nitpicky = True
# Not documented here: what our classes are made of.
nitpick_ignore_regex = [("py:.*", r"(numpy|npt|np|pyvista|pv|vtkmodules)\..*|vtk[A-Z]\w*|Path|BeforeAfter")]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_custom_sections = ["Guarantees"]
# Types of parameters are words, not links.
napoleon_use_param = napoleon_use_rtype = False
napoleon_use_ivar = False

html_theme = "pydata_sphinx_theme"
html_title = "vtksmooth"
html_show_sourcelink = False
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_math_renderer = "mathml"

linkcheck_anchors = False


sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/\d\d_",
    "image_scrapers": ("pyvista",),
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "write_computation_times": False,
    "download_all_examples": False,
    "notebook_extensions": set(),
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1_000_000,
    "nested_sections": False,
}


def _name_what_is_outside(app: Any, page: str, source: list[str]) -> None:
    # Links to files beside docs are for who reads a page in the repository; the site has no such files.
    if "/" not in page:
        source[0] = re.sub(r"\[[^]]+\]\(\.\./([^)]+)\)", r"`\1`", source[0])


def _need_no_network(app: Any, error: Exception | None) -> None:
    loaded = re.compile(r'<(?:script|link|img|iframe)[^>]+(?:src|href)="(?:https?:)?//[^"]*')
    for page in Path(app.outdir).rglob("*.html"):
        if found := loaded.search(page.read_text(encoding="utf-8")):
            raise ExtensionError(f"{page.name} loads from outside: {found[0]}")


def _mathml(node: nodes.math | nodes.math_block, as_block: bool) -> str:
    try:
        return tex2mathml(node.astext(), as_block=as_block)
    except MathError as error:
        raise ExtensionError(f"{node.source}: {error} {node.astext()}") from error


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="formula">{_mathml(node, as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Write formulae as MathML, which browsers show without a script from elsewhere."""
    app.connect("source-read", _name_what_is_outside)
    app.connect("build-finished", _need_no_network)
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
