"""skydist.inp: radiances or masses over zenith and azimuth indices, for one or more wavelengths."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.formats.report import Report
from aomc_sky.formats.skydist.head import SkyHead, read_declaration, read_head
from aomc_sky.formats.skydist.rows import read_rows, read_rows_fast
from aomc_sky.formats.text_file import read_bytes, split_lines, write_atomically


class Bins(enum.Enum):
    """What the indices are: numbers of equal bins, or whole degrees."""

    EQUAL = "equal"
    DEGREES = "degrees"


class Values(enum.Enum):
    """What the listed values are: radiances, or masses (shares of the photons)."""

    RADIANCE = "radiance"
    MASS = "mass"


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyTable:
    """The contents of skydist.inp.

    Parameters
    ----------
    wavelength_nm : ndarray, float64, shape (n_table,)
        Wavelengths in file order. [nm]
    radiance : ndarray, float64, shape (n_table, n_zenith, n_azimuth + 1)
        Listed values at [wavelength, zenith index - 1, azimuth index], absent ones 0. [0 or more]
    line : ndarray, int32, shape of `radiance`
        Line that each value stood in, 0 where absent; all 0 by default.
    declared_bins : Bins or None
    declared_values : Values or None
        What the comment after the data says, in files that we wrote.
    path : str
        The file, for messages.
    """

    wavelength_nm: np.ndarray
    radiance: np.ndarray
    line: np.ndarray = None  # type: ignore[assignment]
    declared_bins: Bins | None = None
    declared_values: Values | None = None
    path: str = ""

    def __post_init__(self) -> None:
        if self.line is None:
            object.__setattr__(self, "line", np.zeros(self.radiance.shape, np.int32))


def read_skydist(
    path: str | Path,
    *,
    lenient: bool = False,
    downgrade: frozenset[str] = frozenset(),
    max_memory_bytes: int | None = None,
) -> SkyTable:
    """Read skydist.inp.

    Parameters
    ----------
    path : str or Path
        The file.
    lenient : bool
        A wrong row count, and duplicates that differ (the last one wins), become warnings.
    downgrade : frozenset of str
        Codes that become warnings in any case (E308 under --compat aomc).
    max_memory_bytes : int, optional
        Refuse a table that takes more, its absent bins included, before it takes any; 2 GiB by default. [bytes]

    Returns
    -------
    SkyTable
        Arrays are read-only.

    Raises
    ------
    InputFileError
        Every problem of the file, with line and column.

    Cost
    ----
    About the time of numpy.loadtxt; a file that does not pass its checks is read again to say why.
    """
    data = read_bytes(path)
    report = Report(path=str(path), lenient=lenient, downgrade=downgrade)
    n_head = _head_bytes(data)
    head = read_head(split_lines(data[:n_head]), len(data), report, max_memory_bytes)
    if head is None and n_head < len(data):
        head = read_head(split_lines(data), len(data), report := _fresh(report), max_memory_bytes)
    if head is None:
        report.close()
        raise AssertionError("a head that cannot be read leaves an error")
    entries = read_rows_fast(data, head)
    if entries is None:
        lines = split_lines(data)
        entries = read_rows(lines, head, report)
    report.close()
    radiance, line = entries
    bins, values = read_declaration(data)
    for array in (radiance, line, head.wavelength_nm):
        array.flags.writeable = False
    return SkyTable(
        wavelength_nm=head.wavelength_nm,
        radiance=radiance,
        line=line,
        declared_bins=Bins(bins) if bins else None,
        declared_values=Values(values) if values else None,
        path=str(path),
    )


def _head_bytes(data: bytes) -> int:
    """Length of a piece that surely holds the header and the wavelengths, cut at a line end."""
    end = data.find(b"\n", min(len(data), 262_144))
    return len(data) if end < 0 else end + 1


def _fresh(report: Report) -> Report:
    return Report(path=report.path, lenient=report.lenient, downgrade=report.downgrade)


def write_skydist(
    table: SkyTable, path: str | Path, *, bins: Bins = Bins.EQUAL, values: Values = Values.RADIANCE
) -> None:
    """Write skydist.inp; reading it back gives the same float64 values, bins and meaning.

    Parameters
    ----------
    table : SkyTable
        What to write; zeros are left out.
    path : str or Path
        The file, replaced atomically.
    bins, values : Bins, Values
        Stand in a comment after the data, which AOMC ignores and `read_skydist` obeys.
    """
    n_table, n_zenith, n_columns = table.radiance.shape
    wave, zenith, azimuth = np.nonzero(table.radiance)
    value = table.radiance[wave, zenith, azimuth]
    head = f"{value.size} {n_zenith} {n_columns - 1} {n_table}\n"
    wavelengths = " ".join(repr(float(w)) for w in table.wavelength_nm)
    rows = [
        f"{w} {z} {a} {v!r}\n"
        for w, z, a, v in zip((wave + 1).tolist(), (zenith + 1).tolist(), azimuth.tolist(), value.tolist(), strict=True)
    ]
    note = f"# aomc-sky bins={bins.value} values={values.value}\n"
    write_atomically(path, "".join([head, wavelengths, "\n", *rows, note]))


__all__ = ["Bins", "SkyHead", "SkyTable", "Values", "read_skydist", "write_skydist"]
