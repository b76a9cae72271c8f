"""Pictures of matplotlib as files: written atomically, with the same bytes for the same picture."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.text_file import write_bytes_atomically
from aomc_sky.outputs.run_folder import SOFTWARE

SUFFIXES = (".png", ".svg", ".pdf")
"""Files of one picture."""

_INSIDE_DPI = 300.0


def picture_path(path: str | Path) -> Path:
    """The path of a picture, whose suffix says its format."""
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise UsageError(f"a picture ends in {', '.join(SUFFIXES)}, got {target.name!r}")
    return target


def save_picture(figure: Any, target: Path, *, dpi: float) -> None:
    """Write a picture atomically; `dpi` is that of a PNG, pictures inside an SVG or PDF have at least 300."""
    # no date and no random names, so that equal pictures give equal files
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
