"""Rows of the reference tables of atmospheres, and the media they were made for."""

from functools import cache

import numpy as np

from tests.support import atmospheres
from tests.support.shared import REFERENCE, csv_rows

TABLES = REFERENCE / "atmosphere"
MEDIA = {"rayleigh": atmospheres.molecules_only, "mol_ozone": atmospheres.mol_ozone, "full": atmospheres.full}


@cache
def rows(name):
    return csv_rows(TABLES / name)


def grouped(name, *keys):
    """Rows of a table by the values of some columns."""
    groups = {}
    for row in rows(name):
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def column(some, key):
    return np.array([float(row[key]) for row in some])
