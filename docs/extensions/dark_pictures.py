"""Pictures of programs and notebooks in the site's dark mode: each has a twin with light ink on the dark paper.

`darkened` restyles a figure of matplotlib; data keep their colours. Where a page, a card or a thumbnail has the picture
`name.png` and `name_dark.png` lies beside it, the first is shown in light mode and its twin in dark mode.
"""

from __future__ import annotations

import base64
import contextlib
import io
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from docutils import nodes
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from PIL import Image, ImageOps
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

PAPER, INK = "#14181e", "#d0d4da"
_DARK, _LIGHT = 0.4, 0.97  # greys that are ink, and that are paper
DPI = 150


def _recoloured(colour: Any, *, is_area: bool) -> str | None:
    """The colour on dark paper, or None where it stays: greys alone change, ink and, of areas, paper."""
    if isinstance(colour, str) and colour.lower() in ("none", "auto"):
        return None
    *_, alpha = (1.0,) if isinstance(colour, str) or len(colour) == 3 else colour
    rgb = np.array(to_rgb(colour))
    if alpha == 0 or np.ptp(rgb) > 0.05 or _DARK < rgb.mean() < _LIGHT or (rgb.mean() >= _LIGHT and not is_area):
        return None
    grey = rgb.mean()
    return to_hex(np.array(to_rgb(PAPER)) * grey + np.array(to_rgb(INK)) * (1.0 - grey))


_PROPERTIES: tuple[tuple[type, tuple[str, ...], bool], ...] = (
    (Text, ("color",), False),
    (Line2D, ("color", "markeredgecolor"), False),
    (Patch, ("facecolor",), True),
    (Patch, ("edgecolor",), False),
)
"""Kind of artist, its colours, and whether white is paper there."""


@contextlib.contextmanager
def darkened(figure: Figure) -> Iterator[Figure]:
    """Give a figure light ink on dark paper while the block runs."""
    figure.draw_without_rendering()  # which makes the ticks
    undo: list[Callable[[], object]] = []
    for artist in figure.findobj():
        if isinstance(artist, Axis):
            params = {name: artist.get_tick_params().get(name, "black") for name in ("color", "labelcolor")}
            new = {name: _recoloured(value, is_area=False) or value for name, value in params.items()}
            artist.set_tick_params(**new)
            undo.append(lambda artist=artist, params=params: artist.set_tick_params(**params))
        for kind, names, is_area in _PROPERTIES:
            for name in names if isinstance(artist, kind) and not isinstance(artist, Axes) else ():
                old = getattr(artist, f"get_{name}")()
                changed = _recoloured(old, is_area=is_area)
                if changed is not None:
                    setter = getattr(artist, f"set_{name}")
                    setter(changed)
                    undo.append(lambda setter=setter, old=old: setter(old))
    try:
        yield figure
    finally:
        for one in reversed(undo):
            one()


def dark_path(path: str | Path) -> Path:
    """The twin of a picture."""
    return Path(path).with_name(f"{Path(path).stem}_dark{Path(path).suffix}")


def save_twin(figure: Figure, path: str | Path) -> None:
    """Save the twin of a picture of the gallery."""
    with darkened(figure):
        figure.savefig(dark_path(path), dpi=DPI)


def both_as_html(figure: Figure) -> str:
    """A figure of a notebook, and its twin, as two images of a page."""

    def image(mode: str) -> str:
        data = io.BytesIO()
        figure.savefig(data, format="png", dpi=DPI, bbox_inches="tight")
        text = base64.b64encode(data.getvalue()).decode("ascii")
        width = Image.open(data).width * 96 // DPI
        return f'<img class="only-{mode}" alt="figure" width="{width}" src="data:image/png;base64,{text}">'

    light = image("light")
    with darkened(figure):
        return light + image("dark")


class _Twins(SphinxTransform):
    """Put the twin of a picture after it."""

    default_priority = 400

    def apply(self, **_: Any) -> None:
        for node in list(self.document.findall(nodes.image)):
            uri = node["uri"]
            folder = Path(self.env.srcdir) if uri.startswith("/") else Path(self.env.doc2path(self.env.docname)).parent
            is_said = any(name.startswith("only-") for name in node["classes"])
            if is_said or "://" in uri or not dark_path(folder / uri.lstrip("/")).is_file():
                continue
            twin = node.deepcopy()
            twin["uri"] = str(Path(uri).with_name(dark_path(uri).name))
            twin["classes"] = [*node["classes"], "only-dark"]
            node["classes"] = [*node["classes"], "only-light"]
            node.parent.insert(node.parent.index(node) + 1, twin)


def _thumbnails(app: Sphinx) -> None:
    """Make the twins of thumbnails from those of their pictures."""
    for thumb in Path(app.srcdir, "gallery", "images", "thumb").glob("sphx_glr_*_thumb.png"):
        picture = dark_path(thumb.parent.parent / f"{thumb.stem.removesuffix('_thumb')}_001.png")
        if picture.is_file():
            with Image.open(thumb) as light, Image.open(picture) as dark:
                ImageOps.pad(dark.convert("RGB"), light.size, color=PAPER).save(dark_path(thumb))


def setup(app: Sphinx) -> dict[str, Any]:
    """Use twins; kernels of notebooks show both."""
    os.environ["PYTHONSTARTUP"] = str(Path(__file__).with_name("dark_notebooks.py"))
    app.connect("builder-inited", _thumbnails, priority=900)  # after the gallery
    app.add_transform(_Twins)
    return {"parallel_read_safe": True}
