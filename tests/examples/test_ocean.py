"""examples/c/ocean.c against published means, doubling, exact laws, and itself with defects."""

import csv
import re
import subprocess
import sys

import numpy as np
import pytest

import aomc_sky as sky
from tests.reference import layer
from tests.support.builds import apart
from tests.support.host_programs import EXAMPLES, FLAGS, copied, make, needs_host, run
from tests.support.shared import REFERENCE, REPOSITORY

N, REPLICATES = 65_536, 24
SIGMAS = 5.0
DEPTHS = (1.0, 5.0, 10.0)
INDEX, SUN_MU = 1.34, 0.5
STRETCH = {(1, 0.2): 0.7, (1, 0.9): 0.2, (2, 0.2): 0.7, (2, 0.9): 0.05}
"""By problem and albedo."""
RAYLEIGH = np.array([1, 0, 0.1])
PAGE = (REPOSITORY / "docs" / "published_problems.md").read_text()


def rows_of(name):
    lines = (EXAMPLES / "c" / name).read_text().splitlines()
    assert "Applied Optics 32, 7484" in lines[0]
    return list(csv.DictReader(lines[1:]))


PUBLISHED = {
    (int(row["problem"]), float(row["albedo"]), row["quantity"], float(row["optical_depth"])): (
        float(row["mean"]),
        float(row["coefficient_of_variation"]),
    )
    for row in rows_of("mobley_1993.csv")
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The program, and the sun of the problems."""
    folder = copied("c", tmp_path_factory.mktemp("ocean"))
    make(folder, "ocean", flags=apart(FLAGS))
    scene = sky.Scene(wavebands=[500.0], n_photons=N, components=sky.DirectBeam(sun_zenith_deg=60.0))
    sky.write_source(scene.source(seed=1, replicates=REPLICATES), folder / "beam.sky")
    return folder


@pytest.fixture(scope="module")
def matt(folder):
    """The same without light that the surface sends down again."""
    code = (folder / "ocean.c").read_text()
    part = "weight * reflectance(z, 1 / refractive_index)"
    assert code.count(part) == 1
    copy = copied("c", folder / "matt")
    (copy / "ocean.c").write_text(code.replace(part, f"0 * {part}"))
    make(copy, "ocean", flags=apart(FLAGS))
    return copy / "ocean"


def printed(folder, *options, program="./ocean", threads=1):
    """Value and standard error by quantity and depth."""
    command = [program, "beam.sky", "-d", "1,5,10", "-i", "0.5", *options]
    text = run([str(word) for word in command], folder, OMP_NUM_THREADS=str(threads))
    rows = [line.split() for line in text.splitlines()[2:]]
    assert len(rows) == 15
    return {(name, float(depth)): np.array([float(value), float(error)]) for depth, name, value, error in rows}


def problem(case, albedo=None):
    """Options of a problem, or of one with another albedo."""
    number, own = case
    phase = "rayleigh" if number == 1 else "petzold.csv"
    return ("-p", phase, "-a", own if albedo is None else albedo, "-s", STRETCH[case])


@pytest.fixture(scope="module")
def found(folder):
    return {case: printed(folder, *problem(case)) for case in STRETCH}


def petzold():
    """Scattering angles, and the light of thin slices around them, whose sum is 1; and the integral of the table."""
    rows = rows_of("petzold.csv")
    angle, p = (np.array([float(row[key]) for row in rows]) for key in ("angle_deg", "phase_function_per_sr"))
    slope = np.diff(np.log(p)) / np.diff(np.log(angle))
    logs = [np.linspace(np.log(angle[0]) - 12, np.log(angle[0]), 1001)]
    logs += [np.linspace(low, high, 101) for low, high in np.log(np.column_stack([angle[:-1], angle[1:]]))]
    middle = np.exp(np.concatenate([(edges[1:] + edges[:-1]) / 2 for edges in logs]))
    width = np.concatenate([np.diff(edges) for edges in logs])
    row = np.clip(np.searchsorted(angle, middle) - 1, 0, angle.size - 2)
    theta = np.deg2rad(middle)
    light = 2 * np.pi * p[row] * (middle / angle[row]) ** slope[row] * np.sin(theta) * theta * width
    return middle, light / light.sum(), light.sum()


def moments(n):
    """The first n Legendre moments of Petzold's phase function."""
    middle, light, integral = petzold()
    assert integral == pytest.approx(0.993, abs=5e-4)
    before, now = np.ones_like(middle), np.cos(np.deg2rad(middle))
    mu, found = now, []
    for order in range(n):
        found.append(np.sum(light * before))
        before, now = now, ((2 * order + 3) * mu * now - (order + 1) * before) / (order + 2)
    return np.array(found)


def by_doubling(case):
    """Ed, Eu, Eou and Lu at the three depths, without any random number."""
    number, albedo = case
    chi, peak, n = RAYLEIGH, 0.0, 24
    if number == 2:  # the peak counts as light that goes on (delta-M)
        *chi, peak = moments(97)
        chi, n = (np.array(chi) - peak) / (1 - peak), 48
    scale = 1 - albedo * peak
    base = layer.nodes(n, INDEX)
    mu_water = np.sqrt(1 - (1 - SUN_MU**2) / INDEX**2)
    width = 1e-9  # of the node of the beam
    mu, weight = (np.append(np.append(a[:-1], b), a[-1]) for a, b in ((base.mu, mu_water), (base.weight, width)))
    at = layer.Nodes(mu=mu, weight=weight, index=INDEX)
    surface, unit = np.diag(layer.fresnel(at.air_mu, INDEX)), np.eye(mu.size)
    beam = np.zeros(mu.size)
    beam[-2] = 0.5 * (1 - layer.fresnel(np.array(SUN_MU), INDEX)) / (2 * np.pi * mu_water * width)
    inner = (1 - peak) * albedo / scale
    deep, _ = layer.layer(at, 60.0, inner, chi)
    exact = {}
    for depth in DEPTHS:
        reflection, through = layer.layer(at, depth * scale, inner, chi)
        both = np.block(
            [[unit - surface @ reflection, -surface @ through @ deep], [-through, unit - reflection @ deep]]
        )
        down = np.linalg.solve(both, np.append(beam, 0 * beam))[mu.size :]
        up, flux = deep @ down, 2 * np.pi * mu * weight
        exact |= {("Ed", depth): flux @ down, ("Eu", depth): flux @ up, ("Lu", depth): up[-1]}
        exact["Eou", depth] = 2 * np.pi * weight @ up
    if number == 2:  # a radiance shows that polynomials end, an irradiance does not
        exact = {key: value for key, value in exact.items() if key[0] != "Lu"}
    return exact


def farthest(table, exact):
    """The largest difference, in standard errors."""
    return max(abs(table[key][0] - value) / table[key][1] for key, value in exact.items())


def outside(table, case):
    """Published values that are farther away than the models are from each other, and our error."""
    beyond = []
    for (*place, quantity, depth), (mean, variation) in PUBLISHED.items():
        if tuple(place) == case:
            value, error = table[quantity, depth]
            half_digit = 0.5 * 10 ** (np.floor(np.log10(mean)) - 2)
            if not abs(value - mean) <= 2 * variation * mean + half_digit + 4 * error:  # NaN is outside
                beyond.append((quantity, depth))
    return beyond


@pytest.mark.parametrize("name", ["petzold.csv", "mobley_1993.csv"])
def test_tables_are_those_of_the_reference(name):
    assert (EXAMPLES / "c" / name).read_text().partition("\n")[2] == (REFERENCE / "ocean" / name).read_text()


@needs_host
class TestPublished:
    @pytest.mark.parametrize("case", STRETCH)
    def test_means_of_seven_models(self, folder, found, case):
        """Within two of their standard deviations; a model that agrees is outside with one value in twenty."""
        assert sum(key[:2] == case for key in PUBLISHED) == 9
        assert outside(found[case], case) == []
        assert outside(printed(folder, *problem(case), "-r", 1.0), case) != []

    @pytest.mark.parametrize("case", STRETCH)
    def test_doubling(self, folder, found, case):
        """Planted: a phase function whose integral is 1.01, which is the same as an albedo that is larger by 1 %."""
        exact = by_doubling(case)
        assert farthest(found[case], exact) < SIGMAS
        assert farthest(printed(folder, *problem(case, 1.01 * case[1])), exact) > SIGMAS

    def test_the_surface_sends_light_down(self, folder, matt):
        case = (1, 0.9)
        assert farthest(printed(folder, *problem(case), program=matt), by_doubling(case)) > SIGMAS


@needs_host
class TestLaws:
    def test_water_that_scatters_nothing(self, folder):
        """Beer's and Fresnel's laws to the last digits of float32; along the unrefracted path it would be seen."""
        mu_water = np.sqrt(1 - (1 - SUN_MU**2) / INDEX**2)
        through = 0.5 * (1 - layer.fresnel(np.array(SUN_MU), INDEX))
        table = printed(folder, "-a", 0)
        by_chance = printed(folder, "-a", 0, "-c", "-n", 0)
        for (quantity, depth), (value, error) in table.items():
            exact = through * np.exp(-depth / mu_water) if quantity == "Ed" else 0
            assert value == pytest.approx(exact, rel=1e-6, abs=0)
            assert error <= 1e-9 * exact
            if quantity != "Ed" or depth < 10:  # few get as deep
                assert abs(by_chance[quantity, depth][0] - exact) <= SIGMAS * by_chance[quantity, depth][1]

    @pytest.mark.parametrize("phase", ["rayleigh", "petzold.csv"])
    def test_light_that_is_scattered_once(self, folder, phase):
        """Lu is T albedo p exp(-tau / mu) / (1 + mu); a phase function that is 1 % too large is seen."""
        albedo, mu = 1e-4, np.sqrt(1 - (1 - SUN_MU**2) / INDEX**2)
        angle = np.rad2deg(np.arccos(-mu))
        p = 3 / (16 * np.pi) * (1 + mu**2)
        if phase != "rayleigh":
            table = np.array([list(map(float, row.values())) for row in rows_of(phase)])
            p = np.exp(np.interp(np.log(angle), *np.log(table.T))) / petzold()[2]
        through = 0.5 * (1 - layer.fresnel(np.array(SUN_MU), INDEX))
        table = printed(folder, "-a", albedo, "-p", phase)
        for depth in DEPTHS[:2]:  # deeper down light scattered twice is not small against it
            exact = through * albedo * p * np.exp(-depth / mu) / (1 + mu)
            assert table["Lu", depth][0] == pytest.approx(exact, rel=3e-3)


@needs_host
class TestProgram:
    @pytest.mark.parametrize("case", [(1, 0.9), (2, 0.2)])
    def test_estimators_and_numbers_give_the_same_light(self, folder, found, case):
        for options in (("-c",), ("-c", "-n", 0), ("-n", 1)):
            other = printed(folder, *problem(case), *options)
            pairs = [
                (value - other[key][0], np.hypot(error, other[key][1])) for key, (value, error) in found[case].items()
            ]
            assert max(abs(difference) / error for difference, error in pairs) < SIGMAS
        assert all(other[key][1] > 0 for key in other)

    def test_threads_change_no_bit(self, folder):
        command = ["./ocean", "beam.sky", "-d", "0,2", "-a", "0.7", "-p", "petzold.csv"]
        assert N // REPLICATES > 2048  # so that a replicate has parts for two threads
        texts = {run(command, folder, OMP_NUM_THREADS=n) for n in ("1", "2", "3")}
        assert len(texts) == 1

    def test_what_is_wrong_is_said(self, folder):
        (folder / "half.csv").write_text("1,1\n90,0.1\n")
        (folder / "back.csv").write_text("angle,p\n1,1\n1,0.1\n180,0.1\n")
        for words, code, says in (
            ("beam.sky", 2, "write -d"),
            ("-d 1", 2, "usage"),
            ("beam.sky -d 1 -a 1", 2, "albedo"),
            ("beam.sky -d 1,2,3,4,5,6,7,8,9", 2, "too many depths"),
            ("beam.sky -d 1 -p nowhere.csv", 2, "cannot be read"),
            ("beam.sky -d 1 -p half.csv", 2, "180 degrees"),
            ("beam.sky -d 1 -p back.csv", 2, "must ascend"),
            ("nowhere.sky -d 1", 1, "cannot be read"),
        ):
            done = subprocess.run(["./ocean", *words.split()], cwd=folder, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stdout, says in done.stderr) == (code, "", True), words


def rows_of_page(text):
    return re.findall(r"^\| ([12]) \| (0\.\d) \| (\d+) \| (Ed|Eou|Lu) \|(.*)\|$", text, re.M)


def test_the_page_has_the_published_values():
    """And ours, within the errors that it prints."""
    rows = rows_of_page(PAGE)
    tables = {case: {} for case in STRETCH}
    for number, albedo, depth, quantity, rest in rows:
        mean, spread, ours, error, ratio = (float(cell.strip().removesuffix(" %")) for cell in rest.split("|"))
        key = (int(number), float(albedo), quantity, float(depth))
        assert (mean, spread) == (PUBLISHED[key][0], pytest.approx(100 * PUBLISHED[key][1]))
        assert ratio == pytest.approx(ours / mean, abs=1e-3)
        tables[key[:2]][key[2:]] = np.array([ours, ours * error / 100])
    assert len(rows) == len(PUBLISHED) == 36
    assert [outside(tables[case], case) for case in STRETCH] == [[]] * 4


@needs_host
@pytest.mark.slow
def test_the_command_of_the_page_prints_its_table(tmp_path):
    """Fewer photons, so that only the published columns are the same."""
    (line,) = re.findall(r"^python (bench/published\.py.*)$", PAGE, re.M)
    text = run([sys.executable, *line.split(), "--photons", "3200"], REPOSITORY, TMPDIR=str(tmp_path))
    published = [[(*place, *rest.split("|")[:2]) for *place, rest in rows_of_page(page)] for page in (text, PAGE)]
    assert published[0] == published[1]
