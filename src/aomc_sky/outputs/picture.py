"""Pictures of matplotlib as files: whole or not at all, and the same bytes for the same picture."""

from __future__ import annotations

import os
import secrets
from pathlib import Path
from typing import Any

from aomc_sky.errors import OutputError, UsageError
from aomc_sky.extras import optional_module

SUFFIXES = (".png", ".svg", ".pdf")


def picture_path(path: str | Path) -> Path:
    """The path of a picture, whose suffix says its format.

    Raises
    ------
    UsageError
        The suffix is none of `SUFFIXES`.
    """
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise UsageError(f"a picture ends in {', '.join(SUFFIXES)}, got {target.name!r}")
    return target


def save_picture(figure: Any, target: Path, *, dpi: int) -> None:
    """Write under a temporary name and rename, so that no half picture stands under the final one.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The picture.
    target : Path
        From `picture_path`.
    dpi : int
        Dots per inch of a PNG.

    Raises
    ------
    OutputError
        The file cannot be written; what stood there before is unchanged.
    """
    temporary = target.with_name(f".{target.stem}.{secrets.token_hex(4)}{target.suffix}")
    try:
        # without a date or random names, so that equal pictures give equal files
        metadata = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
        with optional_module("matplotlib", extra="plot").rc_context({"svg.hashsalt": "aomc-sky"}):
            figure.savefig(temporary, dpi=dpi, metadata=metadata[target.suffix.lower()])
        os.replace(temporary, target)
    except OSError as error:
        raise OutputError(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)
