"""counts.csv: one line per waveband and patch with mass."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource

COLUMNS = dict.fromkeys(
    (
        *("waveband", "wavelength_nm", "sky_wavelength_nm", "component", "zenith_index", "azimuth_index"),
        *("zenith_lo_deg", "zenith_hi_deg", "azimuth_lo_deg", "azimuth_hi_deg", "mass", "expected", "photons"),
    ),
    1,
)
"""Column of counts.csv -> version of the table that brought it. A new column brings a new version: ``| {"name": 2}``.

The first line of a file says its version, since each version has other columns.
"""
WEIGHT = "weight"
"""Last column of runs whose photons are shared out otherwise than light."""
COUNTS_FILES = ("counts.csv", "counts.npz")
"""The file of counts: as text, and for many rows."""

MAX_CSV_ROWS = 1_000_000


def _number(value: float) -> str:
    return "" if np.isnan(value) else repr(float(value))


def cell_texts(source: PhotonSource, cells: np.ndarray | None = None) -> list[str]:
    """Component, indices and bounds of cells, by default of all, as in counts.csv; `cells` ascend."""
    texts: list[str] = []
    start = 0
    chosen = np.arange(source.plan.n_cells) if cells is None else cells
    for component in source.plan.components:
        end = start + component.n_cells
        own = chosen[np.searchsorted(chosen, start) : np.searchsorted(chosen, end)] - start
        grid, start = component.grid, end
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


def counts_csv(source: PhotonSource, bands: list[int], masses: list[np.ndarray]) -> bytes:
    """The text of counts.csv for bands with these masses."""
    is_lit = np.any([mass > 0 for mass in masses], axis=0)
    texts, text_of = cell_texts(source, np.flatnonzero(is_lit)), np.cumsum(is_lit) - 1
    counts = source.counts
    has_bias = source.has_bias
    lines = [",".join([*COLUMNS, *([WEIGHT] if has_bias else [])])]
    for band, mass in zip(bands, masses, strict=True):
        plan_band = source.plan.bands[band]
        wavelength, sky = _number(plan_band.wavelength_nm), _number(plan_band.sky_wavelength_nm)
        head = f"{band + 1},{wavelength},{sky},"
        cells = np.flatnonzero(mass)
        launch = source.launch(band)
        key = mass + 1j * launch if has_bias else mass  # cells of a ring share theirs
        _, first, share_of = np.unique(key, return_index=True, return_inverse=True)
        expected = float(plan_band.requested) * launch[first]
        pairs = zip(mass[first].tolist(), expected.tolist(), strict=True)
        shares = [f"{share!r},{photons!r}" for share, photons in pairs]
        weights = [f",{w!r}" for w in source.weights(band)[first].tolist()] if has_bias else [""] * first.size
        columns = (text_of[cells], share_of.ravel()[cells], counts[band, cells])
        rows = zip(*(column.tolist() for column in columns), strict=True)
        lines += [f"{head}{texts[k]},{shares[share]},{n}{weights[share]}" for k, share, n in rows]
    return "\n".join([*lines, ""]).encode("ascii")


def table_version(data: bytes) -> int:
    """The version of the table that a file begins with, or 0."""
    head = data.partition(b"\n")[0].decode("ascii", "replace").removesuffix(f",{WEIGHT}").split(",")
    return max(
        (v for v in COLUMNS.values() if head == [name for name, since in COLUMNS.items() if since <= v]), default=0
    )


def in_columns_of(found: bytes, made: bytes) -> bytes:
    """The file of counts as it is made now; where the one that was found is older, with the columns of its version."""
    version = table_version(found)
    if not 0 < version < table_version(made):
        return made
    kept = [k for k, since in enumerate(COLUMNS.values()) if since <= version]
    kept += [len(COLUMNS)] * made.partition(b"\n")[0].endswith(f",{WEIGHT}".encode())
    rows = (line.split(b",") for line in made.splitlines())
    return b"".join(b",".join(row[k] for k in kept) + b"\n" for row in rows)


def counts_npz(source: PhotonSource, bands: list[int], masses: list[np.ndarray]) -> bytes:
    """The bytes of counts.npz: the arrays of counts.csv, shape (n_band, n_cell)."""
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {
        "waveband": np.array(bands, dtype=np.int64) + 1,
        "mass": np.stack(masses),
        "photons": source.counts[bands],
        "cell": np.array(cell_texts(source), dtype=np.str_),
    }
    if source.has_bias:
        arrays["weight"] = np.stack([source.weights(band) for band in bands])
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def chosen_bands(source: PhotonSource) -> list[int]:
    """Wavebands of a run: those with requested photons, or all if there are none. [0-based]"""
    bands = source.plan.bands
    return [number for number, band in enumerate(bands) if band.requested > 0] or list(range(len(bands)))


def counts_file(source: PhotonSource) -> tuple[str, bytes]:
    """Name and bytes of the counts file of a run: CSV up to a million rows, npz above."""
    bands = chosen_bands(source)
    masses = source.plan.masses(bands)
    is_text = sum(map(np.count_nonzero, masses)) <= MAX_CSV_ROWS
    return COUNTS_FILES[not is_text], (counts_csv if is_text else counts_npz)(source, bands, masses)
