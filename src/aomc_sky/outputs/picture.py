"""Pictures of matplotlib as files: complete or not at all, and the same bytes for the same picture."""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.text_file import write_bytes_atomically
from aomc_sky.outputs.folder.target_file import SOFTWARE

SUFFIXES = (".png", ".svg", ".pdf")
"""Files of one picture."""

_INSIDE_DPI = 300.0

MOVING_SUFFIX = ".gif"
"""Files of pictures that follow each other."""


def picture_path(path: str | Path, *, may_move: bool = False) -> Path:
    """The path of a picture, whose suffix says its format, `MOVING_SUFFIX` among them where it `may_move`."""
    target = Path(path)
    suffixes = (*SUFFIXES, MOVING_SUFFIX) if may_move else SUFFIXES
    if target.suffix.lower() not in suffixes:
        raise UsageError(f"a picture ends in {', '.join(suffixes)}, got {target.name!r}")
    return target


def save_picture(figure: Any, target: Path, *, dpi: float) -> None:
    """Write a picture, complete or not at all.

    `dpi` is that of a PNG; pictures inside an SVG or PDF have 300 dots per inch at least.
    """
    # without a date or random names, so that equal pictures give equal files
    metadata = {
        ".png": {"Software": SOFTWARE},
        ".svg": {"Date": None, "Creator": SOFTWARE},
        ".pdf": {"CreationDate": None, "Creator": SOFTWARE},
    }
    rc_context = optional_module("matplotlib", extra="plot").rc_context
    suffix, picture = target.suffix.lower(), io.BytesIO()
    with rc_context({"svg.hashsalt": "aomc-sky"}):
        figure.savefig(
            picture,
            format=suffix[1:],
            dpi=dpi if suffix == ".png" else max(dpi, _INSIDE_DPI),
            metadata=metadata[suffix],
        )
    write_bytes_atomically(target, picture.getvalue())


def save_animation(figures: Iterable[Any], target: Path, *, palette: bytes, frame_ms: int) -> int:
    """Write figures as frames of a GIF that repeats, complete or not at all; return their number.

    Figures are of one size, with Agg canvases; each is drawn and dropped before the next one is asked for. `palette`
    is red, green and blue of up to 256 colours: every dot takes the nearest one. `frame_ms` is rounded to hundredths
    of a second.
    """
    image = optional_module("PIL.Image", extra="plot")
    frames = [_frame(figure, image, palette) for figure in figures]
    picture, comment = io.BytesIO(), SOFTWARE.encode()
    options = {"save_all": True, "duration": frame_ms, "loop": 0, "optimize": False, "comment": comment}
    frames[0].save(picture, format="GIF", append_images=frames[1:], **options)
    write_bytes_atomically(target, picture.getvalue())
    return len(frames)


def _frame(figure: Any, image: Any, palette: bytes) -> Any:
    """One frame in the colours of a palette."""
    figure.canvas.draw()
    dots = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(np.int64)
    numbers, index = np.unique(dots @ np.array([65536, 256, 1]), return_inverse=True)
    rgb = np.stack([numbers >> 16, numbers >> 8 & 255, numbers & 255], axis=1)
    colours = np.frombuffer(palette, np.uint8).reshape(-1, 3).astype(np.int64)
    # the nearest colour; |c|^2 is the same for all and left out
    nearest = ((colours**2).sum(axis=1) - 2 * rgb @ colours.T).argmin(axis=1).astype(np.uint8)
    frame = image.fromarray(nearest[index].reshape(dots.shape[:2]))
    frame.putpalette(palette)
    return frame
