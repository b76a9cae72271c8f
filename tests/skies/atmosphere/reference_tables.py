"""Rows of the reference tables of atmospheres, and the media they were made for."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from functools import cache

import numpy as np
import pytest

from aomc_sky.skies.atmosphere.medium import Medium
from tests.support import atmospheres
from tests.support.shared import SHARED

TABLES = SHARED / "atmosphere"
Row = dict[str, str]
MEDIA: dict[str, Callable[..., Medium]] = {
    "rayleigh": atmospheres.molecules_only,
    "mol_ozone": atmospheres.mol_ozone,
    "full": atmospheres.full,
}

needs_tables = pytest.mark.skipif(not TABLES.is_dir(), reason="the reference data are not beside the repository")


@cache
def rows(name: str) -> tuple[Row, ...]:
    """All rows of a table, none where the reference data are not there."""
    if not (TABLES / name).is_file():
        return ()
    with (TABLES / name).open(encoding="utf-8") as file:
        return tuple(csv.DictReader(file))


def grouped(name: str, *keys: str) -> dict[tuple[str, ...], list[Row]]:
    """Rows of a table by the values of some columns."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows(name):
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def column(some: Iterable[Row], key: str) -> np.ndarray:
    return np.array([float(row[key]) for row in some])
