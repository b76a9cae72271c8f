"""What ``aomc-sky plot`` prints."""

from __future__ import annotations

import json

from aomc_sky.cli.plot_files import Drawn
from aomc_sky.outputs.picture import MOVING_SUFFIX
from aomc_sky.pictures.style import plain_label


def as_text(drawn: Drawn) -> str:
    """A line for the file, and one for what it leaves out."""
    n = len(drawn.picture.domes)
    parts = "frame" if drawn.path.suffix.lower() == MOVING_SUFFIX else "dome"
    line = (
        f"{drawn.path}: {n} {parts}{'s' if n > 1 else ''} of {drawn.kind.value}, "
        f"{plain_label(drawn.picture.quantity.label)}, {drawn.path.stat().st_size} bytes"
    )
    if n < drawn.n_panels:
        line += f"\nnote: {drawn.n_panels} wavebands, {n} spread over them are drawn; choose with --waveband I"
    return line


def as_json(drawn: Drawn) -> str:
    """The same as one JSON object."""
    values = {
        "out": str(drawn.path),
        "bytes": drawn.path.stat().st_size,
        "of": drawn.kind.name.lower(),
        "quantity": plain_label(drawn.picture.quantity.label),
        "domes": [dome.title.split("\n")[0] for dome in drawn.picture.domes],
        "left_out": drawn.n_panels - len(drawn.picture.domes),
    }
    return json.dumps(values)
