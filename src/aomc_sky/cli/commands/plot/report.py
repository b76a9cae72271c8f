"""What ``aomc-sky plot`` prints."""

from __future__ import annotations

import json
from typing import Any

from aomc_sky.cli.commands.plot.files import Drawn
from aomc_sky.outputs.picture import MOVING_SUFFIX
from aomc_sky.pictures.drawing.style import plain_label


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
    if drawn.maps:
        line += f"\n{_largest(drawn)}"
    return line


def _largest(drawn: Drawn) -> str:
    """Where photons are farthest off."""
    from aomc_sky.verify.report import largest_pull

    worst = largest_pull(drawn.maps)
    if worst is None:
        return "largest pull: none, for every zone expects too few photons to say"
    pulls, ring, column = worst
    zenith, azimuth = pulls.zones.zenith_bounds_deg[ring], pulls.zones.azimuth_bounds_deg[column]
    return (
        f"largest pull: {pulls.pull[ring, column]:+.2f} of {sum(p.pull.size for p in drawn.maps)}, in waveband "
        f"{pulls.waveband}, zenith {zenith[0]:.2f} to {zenith[1]:.2f}, azimuth {azimuth[0]:.2f} to {azimuth[1]:.2f} "
        f"deg: {pulls.observed[ring, column]:.6g} photons, {pulls.expected[ring, column]:.6g} by {pulls.against.value}"
    )


def _largest_json(drawn: Drawn) -> dict[str, Any] | None:
    from aomc_sky.verify.report import cell_json, largest_pull

    worst = largest_pull(drawn.maps)
    if worst is None:
        return None
    return {"waveband": worst[0].waveband, "against": worst[0].against.name.lower(), **cell_json(*worst)}


def as_json(drawn: Drawn) -> str:
    """The same as one JSON object."""
    values = {
        "out": str(drawn.path),
        "bytes": drawn.path.stat().st_size,
        "of": drawn.kind.name.lower(),
        "quantity": plain_label(drawn.picture.quantity.label),
        "domes": [dome.title.split("\n")[0] for dome in drawn.picture.domes],
        "left_out": drawn.n_panels - len(drawn.picture.domes),
        **({"largest_pull": _largest_json(drawn)} if drawn.maps else {}),
    }
    return json.dumps(values)
