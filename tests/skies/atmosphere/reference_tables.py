"""Rows of the reference tables of atmospheres, and the media they were made for."""

from functools import cache

import numpy as np
import pytest

from tests.support import atmospheres
from tests.support.shared import SHARED, csv_rows

TABLES = SHARED / "atmosphere"
MEDIA = {"rayleigh": atmospheres.molecules_only, "mol_ozone": atmospheres.mol_ozone, "full": atmospheres.full}

needs_tables = pytest.mark.skipif(not TABLES.is_dir(), reason="the reference data are not beside the repository")


@cache
def rows(name):
    """All rows of a table, none where the reference data are not there."""
    return csv_rows(TABLES / name) if (TABLES / name).is_file() else ()


def grouped(name, *keys):
    """Rows of a table by the values of some columns."""
    groups = {}
    for row in rows(name):
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def column(some, key):
    return np.array([float(row[key]) for row in some])
