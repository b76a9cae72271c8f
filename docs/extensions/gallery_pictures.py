"""Pictures of the gallery: figures that a block of a script made, by pyplot or without it; warnings without paths."""

from __future__ import annotations

import warnings
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

warnings.formatwarning = lambda message, category, *_: f"{category.__name__}: {message}\n"  # no path of this machine


def figures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save what pyplot has open and every `Figure` that has a name, each once, and return where they are shown."""
    seen = block_vars.setdefault("pictures_shown", [])
    named = [value for value in block_vars["example_globals"].values() if isinstance(value, Figure)]
    opened = [plt.figure(number) for number in plt.get_fignums()]
    paths = []
    for figure in dict.fromkeys(opened + named):
        if figure not in seen:
            seen.append(figure)
            paths.append(next(block_vars["image_path_iterator"]))
            figure.savefig(paths[-1], dpi=150)
    plt.close("all")
    return figure_rst(paths, gallery_conf["src_dir"])
