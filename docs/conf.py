"""Sphinx configuration; the gate builds with warnings as errors."""

from __future__ import annotations

import re
import warnings
from typing import Any

import aomc_sky

project = "aomc-sky"
author = "aomc-sky developers"
copyright = "2026, aomc-sky developers"
version = release = aomc_sky.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "sphinxcontrib.bibtex"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
default_role = "code"

autodoc_typehints = "none"  # the numpydoc sections name types, shapes, units and ranges
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
bibtex_bibfiles = ["references.bib"]

html_theme = "alabaster"
html_theme_options = {
    "description": "The photon source for Monte Carlo light transport in ocean and atmosphere",
    "fixed_sidebar": True,
}

# numpydoc also reads signatures, from the docstrings as they stand
warnings.filterwarnings("ignore", message="Unknown section (Accuracy|Cost)", category=UserWarning)

_OWN_SECTIONS = ("Accuracy", "Cost")


def _house_sections(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Turn the house's sections Accuracy and Cost into notes, and bars of absolute values into text."""
    kept: list[str] = []
    notes: list[str] = []
    target = kept
    for k, line in enumerate(lines):
        underlined = k + 1 < len(lines) and re.fullmatch(r"-{3,}", lines[k + 1].strip()) is not None
        if underlined and line.strip() in _OWN_SECTIONS:
            target = notes
            notes += ["", f"**{line.strip()}.**"]
        elif underlined:
            target = kept
            kept.append(line)
        elif not (target is notes and re.fullmatch(r"-{3,}", line.strip())):
            target.append(line)
    if notes:
        start = next((k + 2 for k, line in enumerate(kept) if line.strip() == "Notes"), None)
        if start is None:
            start = len(kept) + 3
            kept += ["", "Notes", "-----"]
        kept[start:start] = [*notes, ""]
    lines[:] = [re.sub(r"(?<![`|])\|(\S[^|`]*)\|", r"\\|\1\\|", line) for line in kept]


def setup(app: Any) -> None:
    """Run before numpydoc reads the docstrings."""
    app.connect("autodoc-process-docstring", _house_sections, priority=400)
