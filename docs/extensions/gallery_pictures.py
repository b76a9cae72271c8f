"""Pictures of the gallery: figures that a block of a script made, by pyplot or without it; warnings without paths."""

from __future__ import annotations

import os
import warnings
from typing import Any

import matplotlib.pyplot as plt
from dark_pictures import DPI, save_twin
from matplotlib.figure import Figure

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
            figure.savefig(paths[-1], dpi=DPI)
            save_twin(figure, paths[-1])
    plt.close("all")
    title = block_vars["target_file"].rpartition("/")[2].removesuffix(".py").partition("_")[2].replace("_", " ")
    uris = (os.path.relpath(path, gallery_conf["src_dir"]).replace(os.sep, "/") for path in paths)
    return "\n".join(f".. image:: /{uri}\n   :alt: {title}\n   :class: sphx-glr-single-img\n" for uri in uris)
