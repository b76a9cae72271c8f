"""Mutated descriptions: read as a whole, or refused at a place inside the file."""

import warnings

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from aomc_sky.errors import InputFileError
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from tests.support.shared import DATA

TEXTS = [
    path.read_bytes().decode()
    for kind in ("good", "bad")
    for path in sorted((DATA / "atmo" / kind).glob("*.atmo"))
    if "file" not in path.read_bytes().decode()
]
PIECES = (
    *' \t#:{}"`,.-+e0127\n\r\0\ufeff\u00a0\u2028x',
    *("```", "km", "nm", "AU", "^2", "1e9", "inf", "nan", "min=", "count=4,", "\n```\n", "\n{\n", "\n}\n"),
    "version: 6\n",
    'Scatterer "a":',
    'Absorber "molecules":\n{\n',
    "file x.csv",
    "weighted file 1 ",
    "needs interpolation guides\n",
    "ground albedo: 1, 1, 1, 1\n",
)
one_mutation = st.tuples(st.integers(0, 3), st.integers(0, 100), st.integers(0, 60), st.sampled_from(PIECES))
mutations = st.lists(one_mutation, min_size=1, max_size=4)


def mutate(text, changes):
    """Insert or replace, delete, double or swap pieces and lines."""
    lines = text.split("\n")
    for kind, row, column, piece in changes:
        row %= len(lines)
        line = lines[row]
        k = column % (len(line) + 1)
        if kind == 0:
            lines[row] = line[:k] + piece + line[k + column % 2 :]
        elif kind == 1:
            lines[row] = line[:k] + line[k + 1 + column % 3 :]
        elif kind == 2:
            lines[row : row + 1] = [line, line] if column % 2 else []
            lines = lines or [""]
        else:
            other = column % len(lines)
            lines[row], lines[other] = lines[other], lines[row]
    return "\n".join(lines)


def outcome(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return read_atmo(path)
        except InputFileError as error:
            return error


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(changes=mutations, which=st.integers(0, len(TEXTS) - 1))
def test_a_mutated_file_is_read_or_refused_at_a_place(changes, which, tmp_path_factory):
    text = mutate(TEXTS[which], changes)
    path = tmp_path_factory.getbasetemp() / "mutated.atmo"
    path.write_bytes(text.encode())
    found = outcome(path)
    if isinstance(found, InputFileError):
        lines = text.split("\n")
        for problem in found.problems:
            assert problem.code[:2] in ("E4", "E1")
            assert 0 <= problem.line <= len(lines)
            assert not problem.line or 1 <= problem.column <= len(lines[problem.line - 1]) + 1
            assert problem.message
            assert problem.advice or problem.code == "E101"
        assert str(found)
        return
    n = len(found.wavelength_nm)
    rows = [found.solar_irradiance, found.ground_albedo]
    rows += [part.single_scattering_albedo for part in found.scatterers]
    rows += [part.cross_section_m2 for part in found.absorbers]
    assert all(row.shape == (n,) and np.all(row >= 0.0) and np.all(np.isfinite(row)) for row in rows)
    assert np.all(np.diff(found.wavelength_nm) > 0)
    assert found.scatterers
    for part in found.species:
        assert part.number_density.text in text.replace("\r\n", "\n")
