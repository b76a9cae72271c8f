"""Pictures of matplotlib as files: complete or not at all, and the same bytes for the same picture."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.outputs.folder.run_folder import os_error
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
    """Write under a temporary name and rename, so that no half picture has the final one.

    `dpi` is that of a PNG; pictures inside an SVG or PDF have 300 dots per inch at least.
    """
    # without a date or random names, so that equal pictures give equal files
    metadata = {
        ".png": {"Software": SOFTWARE},
        ".svg": {"Date": None, "Creator": SOFTWARE},
        ".pdf": {"CreationDate": None, "Creator": SOFTWARE},
    }
    rc_context = optional_module("matplotlib", extra="plot").rc_context
    with _atomic_target(target) as temporary, rc_context({"svg.hashsalt": "aomc-sky"}):
        suffix = target.suffix.lower()
        figure.savefig(temporary, dpi=dpi if suffix == ".png" else max(dpi, _INSIDE_DPI), metadata=metadata[suffix])


def save_animation(figures: Iterable[Any], target: Path, *, palette: bytes, frame_ms: int) -> int:
    """Write figures as frames of a GIF that repeats, complete or not at all; return their number.

    Figures are of one size, with Agg canvases; each is drawn and dropped before the next one is asked for. `palette`
    is red, green and blue of up to 256 colours: every dot takes the nearest one. `frame_ms` is rounded to hundredths
    of a second.
    """
    image = optional_module("PIL.Image", extra="plot")
    frames = [_frame(figure, image, palette) for figure in figures]
    with _atomic_target(target) as temporary:
        frames[0].save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=frames[1:],
            duration=frame_ms,
            loop=0,
            optimize=False,
            comment=SOFTWARE.encode(),
        )
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


@contextmanager
def _atomic_target(target: Path) -> Iterator[Path]:
    """A temporary name beside the final one, which it gets at the end."""
    temporary = target.with_name(f".{target.stem}.{secrets.token_hex(4)}{target.suffix}")
    try:
        yield temporary
        os.replace(temporary, target)
    except OSError as error:
        raise os_error("write", target, error) from error
    finally:
        temporary.unlink(missing_ok=True)
