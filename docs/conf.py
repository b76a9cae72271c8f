"""Sphinx configuration; the gate builds with warnings as errors, and nothing of the site comes from another host."""

from __future__ import annotations

import sys
from pathlib import Path

import aomc_sky

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

import topics

project = "aomc-sky"
author = "aomc-sky developers"
copyright = "2026, aomc-sky developers"
version = release = aomc_sky.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinxcontrib.bibtex",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "dark_pictures",
    "house_sections",
    "mathml",
    "tables",
]
myst_enable_extensions = ["attrs_inline", "colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
exclude_patterns = ["_build", "static", "templates", "extensions", "**sg_execution_times.rst", "figures"]
templates_path = ["templates"]
default_role = "code"
highlight_language = "none"  # a block without a language is text: what a program prints, a grammar, a file

autodoc_typehints = "none"  # the numpydoc sections name types, shapes, units and ranges
autodoc_member_order = "bysource"
autosummary_context = {"topic_of": topics.topic_of()}
numpydoc_show_class_members = False
toc_object_entries_show_parents = "hide"
bibtex_bibfiles = ["references.bib"]

copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True
copybutton_line_continuation_character = "\\"

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("gallery_pictures.figures",),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "notebook_extensions": set(),
    "show_signature": False,
    "capture_repr": (),  # a program prints what it says; no object with its address
    "min_reported_time": 60,
    "remove_config_comments": True,
}

html_theme = "pydata_sphinx_theme"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_search_scorer = str(Path(__file__).parent / "static" / "scorer.js")
html_title = "aomc-sky"
html_context = {"default_mode": "auto"}
html_favicon = "static/mark.svg"
html_show_sourcelink = False
html_theme_options = {
    "logo": {
        "text": f"aomc-sky {release}",
        "image_light": "static/mark.svg",
        "image_dark": "static/mark.svg",
        "alt_text": "",
    },
    "search_bar_text": "Search",
    "show_prev_next": False,
    "header_links_before_dropdown": 7,
    "navigation_depth": 2,
    "show_toc_level": 1,
    "navbar_align": "left",
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_sidebars = {"index": []}
