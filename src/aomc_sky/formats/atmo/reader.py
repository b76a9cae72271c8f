"""Atmosphere descriptions (``.atmo``), the format of CalcMySky: all of it read and checked, no code evaluated."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from aomc_sky.formats.atmo.builder import Builder
from aomc_sky.formats.atmo.data import AtmosphereDescription
from aomc_sky.formats.atmo.entries import Shared
from aomc_sky.formats.atmo.lines import Lines
from aomc_sky.formats.atmo.scan import scan
from aomc_sky.formats.atmo.spectra import SpectrumReader
from aomc_sky.formats.text_file import Report, read_bytes, refuse

MAX_BYTES = 2**20


def read_atmo(path: str | Path, *, allow_paths: Sequence[str | Path] = ()) -> AtmosphereDescription:
    """Read a description of an atmosphere and the tables that it names.

    Parameters
    ----------
    path : str or Path
        The file, of format version 6, at most 1 MiB.
    allow_paths : sequence of str or Path
        Folders below which tables may lie, beside the folder of the file.

    Returns
    -------
    AtmosphereDescription
        Numbers in SI, spectra on the wavelengths of the file, code blocks as text with their places. Unknown keys,
        keys given twice and a missing ground albedo are warnings.

    Raises
    ------
    InputFileError
        Every problem of the file and of its tables.
    OutputError
        The operating system refuses.
    """
    size = os.stat(path).st_size if os.path.isfile(path) else 0
    if size > MAX_BYTES:
        raise refuse(path, f"the file has {size} bytes; at most {MAX_BYTES} are read", code="E401")
    text = read_bytes(path).decode("utf-8", "surrogateescape")
    lines = [line.removesuffix("\r") for line in text.split("\n")]
    report = Report(path=str(path))
    spectra = SpectrumReader(path=str(path), allow_paths=allow_paths)
    file = Lines(lines=lines, report=report)
    description = Builder(shared=Shared(lines=file, spectra=spectra)).description(scan(file))
    report.problems.sort(key=lambda problem: (problem.line == 0, problem.line, problem.column))
    for problem in spectra.problems:
        report.problems.append(problem)
        report.n_errors += problem.is_error
    report.close()
    assert description is not None, "a report with an error raises"
    return description
