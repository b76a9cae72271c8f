"""Launches of the AOMC program: its sky tables and the photons it sent from each patch."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from aomc_sky.formats.aomc.skydist import read_skydist


def rows(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def radiances(folder: Path) -> np.ndarray:
    """The table of a case, (n_table, n_zenith, n_azimuth), read as `--compat aomc` reads it."""
    return read_skydist(folder / "skydist.inp", downgrade=frozenset({"E308"})).radiance


def launched_totals(folder: Path) -> dict[tuple[int, int], int]:
    """Photons launched by (iterations, sky wavelength from 1)."""
    return {
        (int(row["iterations"]), int(row["sky_wavelength_index"])): int(row["launched"])
        for row in rows(folder / "totals.csv")
    }


def launches(folder: Path, shape: tuple[int, int]) -> Iterator[tuple[int, int, int, np.ndarray]]:
    """Iterations, sky wavelength (from 0), launched total and counts (n_zenith, n_azimuth) of each launch."""
    counts = {key: np.zeros(shape, dtype=np.int64) for key in launched_totals(folder)}
    for row in rows(folder / "counts.csv"):
        key = int(row["iterations"]), int(row["sky_wavelength_index"])
        counts[key][int(row["zenith_index"]) - 1, int(row["azimuth_index"])] = int(row["photons"])
    for (iterations, wavelength), total in launched_totals(folder).items():
        yield iterations, wavelength - 1, total, counts[iterations, wavelength]
