"""counts.csv: one line per waveband and patch with mass."""

from __future__ import annotations

import io

import numpy as np

from aomc_sky.kernels.arithmetic.decimals import shortest_texts
from aomc_sky.source.photon_source import PhotonSource

COLUMNS = (
    "waveband,wavelength_nm,sky_wavelength_nm,component,zenith_index,azimuth_index,"
    "zenith_lo_deg,zenith_hi_deg,azimuth_lo_deg,azimuth_hi_deg,mass,expected,photons"
)
COUNTS_FILES = ("counts.csv", "counts.npz")
"""Names of the file of counts, as text and for many rows."""

MAX_CSV_ROWS = 1_000_000
_BLOCK = 32_768


def _number(value: float) -> str:
    return "" if np.isnan(value) else repr(float(value))


def cell_texts(source: PhotonSource, cells: np.ndarray | None = None) -> list[str]:
    """Component, indices and bounds of cells, all by default, as in counts.csv; ascending."""
    texts: list[str] = []
    start = 0
    for component in source.components:
        end = start + component.n_cells
        chosen = (
            np.arange(start, end)
            if cells is None
            else cells[np.searchsorted(cells, start) : np.searchsorted(cells, end)]
        )
        grid, own = component.grid, chosen - start
        start = end
        if grid is None:
            texts += [f"{component.name},,,,,,"] * own.size
            continue
        zenith = [f"{lo!r},{hi!r}" for lo, hi in grid.zenith_bounds_deg.tolist()]
        azimuth = [f"{lo!r},{hi!r}" for lo, hi in grid.azimuth_bounds_deg.tolist()]
        first, indices = grid.azimuth_first_index, np.divmod(own, grid.n_azimuth)
        texts += [
            f"{component.name},{z + 1},{a + first},{zenith[z]},{azimuth[a]}"
            for z, a in zip(*(index.tolist() for index in indices), strict=True)
        ]
    return texts


def n_rows(source: PhotonSource, bands: list[int]) -> int:
    """Lines that counts.csv would have besides its header."""
    return sum(int(np.count_nonzero(source.mass(band))) for band in bands)


def counts_csv(source: PhotonSource, bands: list[int]) -> bytes:
    """Return counts.csv of the given bands."""
    masses = [source.mass(band) for band in bands]
    is_lit = np.any([mass > 0 for mass in masses], axis=0)
    texts, text_of = np.array(cell_texts(source, np.flatnonzero(is_lit)), dtype=np.bytes_), np.cumsum(is_lit) - 1
    arrays, counts = source.plan.arrays, source.counts
    pieces = [COLUMNS.encode("ascii") + b"\n"]
    for band, mass in zip(bands, masses, strict=True):
        wavelength, sky = (_number(arrays[name][band]) for name in ("wavelength_nm", "sky_wavelength_nm"))
        head = f"{band + 1},{wavelength},{sky},".encode("ascii")
        expected = source.expected(band)
        cells = np.flatnonzero(mass)
        for start in range(0, cells.size, _BLOCK):
            some = cells[start : start + _BLOCK]
            numbers = shortest_texts(np.concatenate([mass[some], expected[some]])).reshape(2, some.size, -1)
            pieces.append(_lines(head, texts[text_of[some]], *numbers, _whole_numbers(counts[band, some])))
    return b"".join(pieces)


def _whole_numbers(values: np.ndarray) -> np.ndarray:
    """Texts of numbers of which many are alike."""
    distinct, index = np.unique(values, return_inverse=True)
    return np.array([str(n) for n in distinct.tolist()], dtype=np.bytes_)[index]


def _lines(head: bytes, *columns: np.ndarray) -> bytes:
    """Rows of a table: what begins every row, then its columns, padded by zero bytes, with commas between them."""
    characters = [np.ascontiguousarray(column).view(np.uint8).reshape(len(column), -1) for column in columns]
    ends = np.cumsum([len(head), *(column.shape[1] + 1 for column in characters)])
    rows = np.empty((len(columns[0]), int(ends[-1])), np.uint8)
    rows[:, : len(head)] = np.frombuffer(head, np.uint8)
    for column, start, end in zip(characters, ends, ends[1:], strict=False):
        rows[:, start : end - 1] = column
    rows[:, ends[1:-1] - 1], rows[:, -1] = ord(","), ord("\n")
    return rows.tobytes().translate(None, b"\0")


def counts_npz(source: PhotonSource, bands: list[int]) -> bytes:
    """Return counts.npz: the arrays behind counts.csv, (n_band, n_cell) each."""
    buffer = io.BytesIO()
    np.savez(
        buffer,
        waveband=np.array(bands, dtype=np.int64) + 1,
        mass=np.stack([source.mass(band) for band in bands]),
        photons=source.counts[bands],
        cell=np.array(cell_texts(source), dtype=np.str_),
    )
    return buffer.getvalue()


def counts_name(source: PhotonSource, bands: list[int]) -> str:
    """Name of the counts file: CSV up to a million rows, npz above."""
    return COUNTS_FILES[n_rows(source, bands) > MAX_CSV_ROWS]


def counts_file(source: PhotonSource, bands: list[int]) -> tuple[str, bytes]:
    """Name and bytes of the counts file."""
    name = counts_name(source, bands)
    return name, (counts_csv if name == COUNTS_FILES[0] else counts_npz)(source, bands)
