"""Phase functions as tables: their norm, the law they are drawn by, and a scene that reads one, by two methods."""

import importlib.util
import sys
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import chi2

import aomc_sky as sky
from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.skies.atmosphere.description.medium import read_medium
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.skies.atmosphere.phase_table import PhaseTable, TabulatedPhase, sphere_integrals, tabulated_phase
from tests.skies.atmosphere.test_backward import drawn_angles
from tests.support.atmospheres import henyey_greenstein_phase
from tests.support.shared import INPUTS

MARINE = INPUTS / "atmosphere" / "clear_marine.atmo"
ANGLES = np.concatenate([np.arange(0.0, 20.0, 0.2), np.arange(20.0, 181.0, 1.0)])


def table(angle_deg, value, wavelength_nm=(0.0,)):
    columns = {"wavelength_nm": np.array(wavelength_nm), "value": np.atleast_2d(value)}
    return PhaseTable(path="t.csv", text="file t.csv", angle_deg=angle_deg, **columns)


def hg(g, angle_deg):
    return henyey_greenstein_phase(g)(np.cos(np.radians(angle_deg)), 0)


def by_quad(angle_rad, value):
    """Integral over the sphere of a function that is linear between its points, piece by piece."""
    pieces = [
        quad(lambda t: np.interp(t, angle_rad, value) * np.sin(t), low, high, epsabs=0.0, epsrel=1e-13)[0]
        for low, high in pairwise(angle_rad.tolist())
    ]
    return 2.0 * np.pi * float(np.sum(pieces))


@pytest.mark.parametrize("angle_deg", [ANGLES, np.array([0.0, 180.0]), np.array([0.0, 1e-3, 3.4, 3.5, 90.0, 180.0])])
def test_the_norm_is_that_of_quadrature(angle_deg):
    value = np.random.default_rng(5).uniform(0.0, 3.0, angle_deg.size)
    angle = np.radians(angle_deg)
    assert sphere_integrals(angle, value[None])[0] == pytest.approx(by_quad(angle, value), rel=2e-13)
    law = tabulated_phase(table(angle_deg, value), np.array([550.0]))
    assert by_quad(law.angle_rad, law.value[0]) == pytest.approx(1.0, rel=2e-13)
    np.testing.assert_allclose(law(np.cos(angle), 0) * law.norm[0], value, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("g", [0.0, 0.5, 0.85])
def test_the_error_of_the_norm_is_what_the_steps_make(g):
    """Henyey and Greenstein's law has the integral 1, so what the table has more is its error."""
    law = tabulated_phase(table(ANGLES, hg(g, ANGLES)), np.array([550.0]))
    assert abs(law.norm[0] - 1.0) < 1.5 * law.norm_error[0] + 1e-15
    assert law.norm_error[0] < 3e-4


def test_columns_are_blended_after_their_norm(tmp_path):
    values = np.stack([hg(0.6, ANGLES), 7.0 * hg(0.8, ANGLES)])
    law = tabulated_phase(table(ANGLES, values, (400.0, 600.0)), np.array([400.0, 450.0, 600.0]))
    np.testing.assert_allclose(law.norm, [1.0, 2.5, 7.0], rtol=3e-4)
    np.testing.assert_allclose(law.value[1], 0.75 * law.value[0] + 0.25 * law.value[2], rtol=1e-14)
    assert by_quad(law.angle_rad, law.value[1]) == pytest.approx(1.0, rel=2e-13)
    (part,) = read_atmo(scene(tmp_path, "file t.csv", t="# made by hand\n\n" + GOOD)).scatterers
    law = part.phase_function
    assert law.text == "file t.csv"
    np.testing.assert_array_equal(law.angle_deg, [0.0, 90.0, 180.0])
    np.testing.assert_array_equal(law.wavelength_nm, [400.0, 600.0])
    np.testing.assert_array_equal(law.value, [[3.0, 1.0, 1.0], [2.0, 1.0, 0.0]])


def sea_salt():
    medium, _ = read_medium(read_atmo(MARINE), [500.0])
    return next(part.phase_function for part in medium.constituents if part.name == "sea_salt")


def drawn_chi_square(drawn, law, n):
    """Chi-square of angles drawn as the paths draw them against integrals of the law over the same cells."""
    found = drawn_angles(drawn, np.random.default_rng(11).random(n))
    assert np.ptp(found[:, 1]) < 0.01  # weights, which counts can leave out where they are alike
    angle = np.degrees(2.0 * np.arcsin(np.minimum(found[:, 0] ** 2, 1.0)))
    edges = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0, 60.0, 90.0, 120.0, 150.0, 170.0, 180.0])
    counts = np.histogram(angle, edges)[0]
    knots = np.unique(np.concatenate([np.radians(edges), law.angle_rad]))
    values = np.interp(knots, law.angle_rad, law.value[0])
    parts = [(knots >= low) & (knots <= high) for low, high in pairwise(np.radians(edges))]
    expected = n * np.array([by_quad(knots[part], values[part]) for part in parts])
    assert expected.min() > 20.0
    return float(((counts - expected) ** 2 / expected).sum()), edges.size - 2


def test_drawn_angles_follow_the_table():
    """100 000 angles; angles that are up to a sixth too small, the planted defect, are found."""
    law = sea_salt()
    found, freedom = drawn_chi_square(law, law, 100_000)
    assert found < chi2.isf(1e-6, freedom)
    squeezed = np.pi * (law.angle_rad / np.pi) ** 1.03
    wrong = TabulatedPhase(angle_rad=squeezed, value=law.value, norm=law.norm, norm_error=law.norm_error)
    assert drawn_chi_square(wrong, law, 100_000)[0] > 2 * chi2.isf(1e-6, freedom)


SCENE = """\
version: 6
atmosphere height: 100 km
Earth radius: 6371 km
Earth-Sun distance: 1 AU
scattering orders: 30
wavelengths: min=500nm,max=500nm,count=1
solar irradiance at TOA: 1.9
ground albedo: 0.1
Scatterer "salt":
{
    number density:
    ```
        return 4.0e8 * exp(-altitude / (1.2*km));
    ```
    phase function: PHASE
    cross section at 1 um: 0.5 um^2
    angstrom exponent: 0
}
"""


def scene(folder, phase, /, **tables):
    """A description with one scatterer, and its tables."""
    for name, text in tables.items():
        (folder / f"{name}.csv").write_text(text)
    path = folder / "salt.atmo"
    path.write_text(SCENE.replace("PHASE", phase))
    return path


def rows(angle_deg, *columns):
    return "".join(", ".join(f"{x:.17g}" for x in row) + "\n" for row in zip(angle_deg, *columns, strict=True))


@pytest.mark.filterwarnings("ignore:in .* directions and wavelengths hardly any path")
@pytest.mark.parametrize("method", ["sos", "mc"])
def test_a_table_gives_the_sky_of_the_formula_it_was_made_of(tmp_path, method):
    """All orders: the table is within 4e-4 of the formula; paths have their errors besides."""
    code = """
    ```
        return vec4((1.0 - 0.49) / (4.0*PI) / pow(1.49 - 1.4*dotViewSun, 1.5));
    ```"""
    options = {
        "wavelength_nm": [500.0], "sun_zenith_deg": 50.0, "sky_zenith_deg": [10.0, 50.0, 75.0],
        "azimuth_from_sun_deg": [0.0, 120.0], "method": method, **({"paths": 2000} if method == "mc" else {}),
    }  # fmt: skip
    (tmp_path / "code").mkdir()
    by_code = sky.solve_atmosphere(scene(tmp_path / "code", code), **options)
    by_table = sky.solve_atmosphere(scene(tmp_path, "file hg.csv", hg=rows(ANGLES, hg(0.7, ANGLES))), **options)
    assert by_code.radiance_by_order.shape[1] > 2
    noise = 4.0 * np.hypot(by_table.standard_error, by_code.standard_error) if method == "mc" else 0.0
    assert np.all(np.abs(by_table.radiance - by_code.radiance) < 2e-3 * by_code.radiance + noise)


GOOD = "angle [deg], 400, 600\n0, 3, 2\n90, 1, 1\n180, 1, 0\n"


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("0\n90\n180\n", "E401", "a row of 1 column where 2 are expected"),
        (GOOD.replace("90, 1, 1", "90, 1"), "E401", "a row of 2 columns where 3 are expected"),
        ("0, 1\n90, -2\n180, 1\n", "E404", "'-2' is outside 0 to 1e+30"),
        ("0, 1\n90, nan\n180, 1\n", "E401", "'nan' is not a number"),
        ("0, 1\n90, 1\n170, 1\n", "E408", "the angles go from 0 to 170 degrees"),
        ("0, 1\n90, 1\n90, 1\n180, 1\n", "E401", "angle 90 is not above 90"),
        ("0, 0\n180, 0\n", "E404", "a column of zeros, which cannot be normalised"),
        ("# nothing\n", "E401", "the file has 0 rows of numbers"),
        (GOOD.replace("400, 600", "600, 400"), "E401", "the wavelengths do not rise"),
        (GOOD.replace("400, 600", "40, 600"), "E404", "'40' is outside 100 to 100000"),
        (GOOD.replace("400, 600", "550, 600"), "E408", "has data from 550 to 600 nm"),
    ],
)
def test_a_bad_table_gets_one_sentence(tmp_path, text, code, message):
    with pytest.raises(InputFileError) as caught:
        read_atmo(scene(tmp_path, "file t.csv", t=text))
    assert code in {problem.code for problem in caught.value.problems}
    assert message in str(caught.value)
    table_problems = [problem for problem in caught.value.problems if problem.path.endswith("t.csv")]
    assert table_problems or code == "E408"
    assert all(problem.advice for problem in caught.value.problems)


def test_files_that_are_doubtful(tmp_path):
    with pytest.raises(InputFileError, match="names a file and has a code block"):
        read_atmo(scene(tmp_path, "file t.csv\n```\nreturn vec4(1.0);\n```", t="0, 1\n180, 1\n"))
    coarse = np.arange(0.0, 181.0, 20.0)
    with pytest.warns(InputWarning) as caught:
        read_medium(read_atmo(scene(tmp_path, "file t.csv", t=rows(coarse, hg(0.85, coarse)))))
    texts = " ".join(str(one.message) for one in caught)
    assert "too far apart" in texts
    assert "has the integral" in texts


def make_tables(monkeypatch):
    """The script that wrote the tables of inputs."""
    spec = importlib.util.spec_from_file_location("make_tables", INPUTS / "make_tables.py")
    script = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, script)  # where dataclasses look
    spec.loader.exec_module(script)
    return script


def test_the_tables_of_inputs_follow_miepython(monkeypatch):
    pytest.importorskip("miepython")
    script = make_tables(monkeypatch)
    angle = np.array([0.0, 1.0, 2.0, 15.0, 90.0, 120.0])
    exact = script.mie(script.SEA_SALT, 500.0, angle, 1000)[0]
    np.testing.assert_allclose(sea_salt()(np.cos(np.radians(angle)), 0), exact, rtol=0.02)


def test_sun_and_ozone_of_inputs_are_what_the_script_writes(tmp_path, monkeypatch):
    """But the comments, which name the version of pvlib."""
    pytest.importorskip("pvlib")
    script = make_tables(monkeypatch)
    monkeypatch.setattr(script, "FOLDER", tmp_path)
    (tmp_path / "spectra").mkdir()
    script.main(["sun", "ozone"])
    for name in ("sun_astm_g173.csv", "ozone.csv"):
        made, shipped = ((folder / "spectra" / name).read_text().splitlines() for folder in (tmp_path, MARINE.parent))
        assert [row for row in made if row[0] != "#"] == [row for row in shipped if row[0] != "#"]
