"""What ``aomc-sky info`` tells of an MCPL file: the head, and the bounds of everything in its records."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from aomc_sky.formats.mcpl.file import McplFile, McplParticles

_MAX_COMMENT = 400


def report_mcpl(path: Path, *, as_json: bool) -> int:
    """Print what a file holds; every record is read and checked."""
    from aomc_sky.formats.mcpl.file import read_mcpl

    file = read_mcpl(path)
    bounds = _bounds(file)
    print(json.dumps(_summary(file, bounds)) if as_json else "\n".join(_lines(file, bounds)))
    return 0


def _columns(part: McplParticles) -> Iterator[tuple[str, str, np.ndarray]]:
    yield "energy", "MeV", part.energy
    for k, axis in enumerate("xyz"):
        yield axis, "cm", part.position[:, k]
    for k, axis in enumerate("xyz"):
        yield f"u{axis}", "", part.direction[:, k]
    yield "time", "ms", part.time
    yield "weight", "", part.weight
    yield "pdg_code", "", part.pdg_code
    yield "user_flags", "", part.user_flags


def _bounds(file: McplFile) -> dict[str, tuple[str, float, float]]:
    """Unit, least and greatest value of every column, by name; nothing of an empty file."""
    bounds: dict[str, tuple[str, float, float]] = {}
    for part in file.blocks():
        for name, unit, values in _columns(part):
            least, greatest = values.min().item(), values.max().item()
            _, before, after = bounds.get(name, (unit, least, greatest))
            bounds[name] = unit, min(before, least), max(after, greatest)
    return bounds


def _summary(file: McplFile, bounds: dict[str, tuple[str, float, float]]) -> dict[str, Any]:
    header = file.header
    return {
        "format": f"MCPL-{header.version}",
        "particles": header.n_particles,
        "bytes": file.data_start + header.n_particles * header.record.itemsize,
        "gzip": file.is_packed,
        "header_bytes": file.data_start,
        "particle_bytes": header.record.itemsize,
        "source": header.source,
        "comments": list(header.comments),
        "blobs": {key: len(data) for key, data in header.blobs},
        "precision": "float64" if header.is_double else "float32",
        "byte_order": "little" if header.is_little_endian else "big",
        "user_flags": header.has_user_flags,
        "polarisation": header.has_polarisation,
        "pdg_code": header.pdg_code or None,
        "weight": header.weight or None,
        "bounds": {name: [least, greatest] for name, (_, least, greatest) in bounds.items()},
    }


def _lines(file: McplFile, bounds: dict[str, tuple[str, float, float]]) -> Iterator[str]:
    from aomc_sky.cli.table import table

    facts = _summary(file, bounds)
    packed = ", compressed by gzip" if file.is_packed else ""
    yield f"{facts['format']} file {file.path}, {facts['particles']} particles, {facts['bytes']} bytes{packed}"
    yield (
        f"head {facts['header_bytes']} bytes, {facts['particle_bytes']} bytes per particle, "
        f"{facts['precision']}, {facts['byte_order']}-endian"
    )
    yield f"source: {_printable(facts['source'])}"
    yield from (f"comment: {_printable(comment)}" for comment in facts["comments"])
    yield from (f"blob: {_printable(key)}, {n} bytes" for key, n in facts["blobs"].items())
    for name, value in (("kind of particle (PDG code)", facts["pdg_code"]), ("weight", facts["weight"])):
        yield f"{name}: {'of each record' if value is None else f'{value:g}, of all'}"
    yield "; ".join(
        f"{name.replace('_', ' ')}: {'yes' if facts[name] else 'no'}" for name in ("user_flags", "polarisation")
    )
    if bounds:
        rows = [(name, f"{low:.9g}", f"{high:.9g}", unit) for name, (unit, low, high) in bounds.items()]
        yield f"\n{table(rows, ('', 'least', 'greatest', 'unit'))}"


def _printable(text: str) -> str:
    """Text without control characters, which would disturb a terminal, and of a length that can be read."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text[:_MAX_COMMENT])
    return shown if len(text) <= _MAX_COMMENT else f"{shown} ... ({len(text)} characters)"
