"""Print what perez.md states: jumps between bins, and differences from reference tables.

python docs/models/measure_perez.py [FOLDER], with FOLDER the one that holds relative_radiance.csv and its companions.
"""

from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez import table
from aomc_sky.skies.perez.sky import PerezSky

Row = dict[str, str]
Line = tuple[str, str, int, float, float]
FIVE = "abcde"
EXTRATERRESTRIAL = 1367.0
DAY_ZERO = 1.03502


def rows_of(path: Path) -> list[Row]:
    """Rows of a table by their column names."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def column(rows: list[Row], name: str) -> np.ndarray:
    """A column as numbers."""
    return np.array([float(row[name]) for row in rows])


def line(name: str, what: str, ours: np.ndarray, theirs: np.ndarray, *, floor: float = 0.0) -> Line:
    """Largest absolute difference, and largest relative one of the values above `floor`."""
    off = np.abs(ours - theirs)
    large = np.abs(theirs) > floor
    return name, what, off.size, float(off.max()), float((off[large] / np.abs(theirs[large])).max())


def usable(rows: list[Row]) -> list[Row]:
    """Rows for which the program printed a sky."""
    return [row for row in rows if row["status"].startswith("ok")]


def floored_elsewhere(row: Row) -> bool:
    """Whether the programs leave Delta below 0.2 where we raise it: epsilon exactly on the border of bin 2."""
    return float(row["eps_in"]) == 1.065 and float(row["delta_in"]) < 0.2


def printed(rows: list[Row]) -> np.ndarray:
    """The coefficients as the table has them, shape (n, 5)."""
    return np.column_stack([column(rows, name) for name in FIVE])


def recomputed(epsilon: np.ndarray, delta: np.ndarray, zenith_deg: np.ndarray) -> np.ndarray:
    """Our coefficients under the limits of the programs, whose bins are in single precision."""
    single = epsilon.astype(np.float32).astype(np.float64)
    return perez.coefficients(np.where(epsilon == 6.2, single, epsilon), delta, np.deg2rad(zenith_deg))


def from_parameters(folder: Path) -> list[Line]:
    """gendaylit_coefficients.csv: a to e from epsilon, Delta and the sun."""
    rows = usable(rows_of(folder / "gendaylit_coefficients.csv"))
    lines = []
    for on_border, what in ((False, "a to e"), (True, "a to e at epsilon = 1.065, Delta < 0.2")):
        part = [row for row in rows if floored_elsewhere(row) == on_border]
        ours = recomputed(column(part, "eps_in"), column(part, "delta_in"), column(part, "Z_deg"))
        lines.append(line("gendaylit_coefficients", what, ours, printed(part), floor=0.1))
    return lines


def spencer(day: np.ndarray) -> np.ndarray:
    """Distance factor of the extraterrestrial irradiance."""
    angle = 2 * np.pi * (day - 1) / 365
    first = 1.00011 + 0.034221 * np.cos(angle) + 0.00128 * np.sin(angle)
    return first + 0.000719 * np.cos(2 * angle) + 0.000077 * np.sin(2 * angle)


def from_irradiance(folder: Path) -> list[Line]:
    """The two tables that start from irradiances: epsilon and Delta by the program's constants."""
    lines: list[Line] = []
    for name in ("gendaylit_irradiance", "gendaylit_dated"):
        rows = [row for row in usable(rows_of(folder / f"{name}.csv")) if float(row["DHI"]) > 0]
        zenith = np.arccos(column(rows, "sun_z")) if name.endswith("dated") else np.deg2rad(column(rows, "Z_deg"))
        zenith = np.clip(zenith, np.deg2rad(3.0), np.pi / 2)
        factor = spencer(column(rows, "day_of_year")) if name.endswith("dated") else np.full(len(rows), DAY_ZERO)
        dni, dhi = column(rows, "DNI"), column(rows, "DHI")
        mass = perez.relative_air_mass(zenith, formula="kasten-1966")
        epsilon = perez.sky_clearness(dni, dhi, zenith)
        epsilon = np.where(epsilon > 12.01, 12.009, epsilon)
        delta = np.clip(mass * dhi / (EXTRATERRESTRIAL * factor), 0.01, 0.6)
        lines.append(line(name, "epsilon", epsilon, column(rows, "eps")))
        lines.append(line(name, "Delta", delta, column(rows, "delta")))
        lines.append(line(name, "a to e", recomputed(epsilon, delta, np.rad2deg(zenith)), printed(rows), floor=0.1))
    return lines


def radiances(folder: Path) -> list[Line]:
    """Eq. (1) over the sky and beside the sun, with printed and with our own coefficients."""
    known = {row["case"]: row for row in rows_of(folder / "gendaylit_coefficients.csv")}
    sky = rows_of(folder / "relative_radiance.csv")
    cases = [name for name in sky[0] if name in known]
    zenith, azimuth = np.deg2rad(column(sky, "theta_deg")), np.deg2rad(column(sky, "phi_from_sun_deg"))
    theirs = np.column_stack([column(sky, case) for case in cases])
    near = rows_of(folder / "aureole.csv")
    offset = column(near, "offset_from_sun_deg")
    lines: list[Line] = []
    for what in ("with printed a to e", "with our a to e"):
        above = np.cos(zenith) >= 0.01
        plain = np.column_stack([relative(known[case], zenith, azimuth, what) for case in cases])
        floored = np.column_stack([relative(known[case], zenith, azimuth, what, floor=True) for case in cases])
        lines.append(line("relative_radiance", f"higher than 0.6°, {what}", plain[above], theirs[above]))
        lines.append(line("relative_radiance", f"lower, {what}", plain[~above], theirs[~above]))
        lines.append(line("relative_radiance", f"lower, {what}, cosine floor", floored[~above], theirs[~above]))
        beside = []
        for row, step in zip(near, offset, strict=True):
            angle = float(known[row["case"]]["Z_deg"]) + step
            turned = np.array([0.0 if angle >= 0 else np.pi])
            beside.append(relative(known[row["case"]], np.deg2rad(np.array([abs(angle)])), turned, what)[0])
        lines.append(line("aureole", what, np.array(beside), column(near, "relative_radiance")))
    return lines


def relative(row: Row, zenith: np.ndarray, azimuth: np.ndarray, what: str, *, floor: bool = False) -> np.ndarray:
    """Eq. (1) of one case; `floor` keeps the cosine in exp(b / cos xi) at 0.01 or more, as the programs do."""
    five = printed([row])[0]
    if what == "with our a to e":
        five = recomputed(column([row], "eps_in"), column([row], "delta_in"), column([row], "Z_deg"))[0]
    sun = np.deg2rad(float(row["Z_deg"]))
    if not floor:
        return perez.relative_radiance(zenith, azimuth, sun, five)
    lowest = np.arccos(np.maximum(np.cos(zenith), 0.01))
    gradient = perez.relative_radiance(lowest, azimuth, sun, five * [1, 1, 0, 0, 0])
    return gradient * perez.relative_radiance(zenith, azimuth, sun, five * [0, 0, 1, 1, 1])


def blended(folder: Path) -> list[Line]:
    """rtrace_radiance.csv: W m-2 sr-1, with the program's cosine floor and its blend of sky and ground."""
    known = {row["case"]: row for row in rows_of(folder / "gendaylit_coefficients.csv")}
    rows = rows_of(folder / "rtrace_radiance.csv")
    factor, ground, sky = rows[0], rows[1], rows[2:]
    zenith = np.deg2rad(column(sky, "theta_deg"))
    cosine = np.cos(zenith)
    azimuth = np.deg2rad(column(sky, "phi_from_sun_deg"))
    ours, pure, theirs = [], [], []
    for case in (name for name in factor if name in known):
        plain = float(factor[case]) * relative(known[case], zenith, azimuth, "with printed a to e", floor=True)
        up = (cosine + 1.01) ** 10
        ours.append((up * plain + float(ground[case]) / up) / (up + 1 / up))
        pure.append(plain)
        theirs.append(column(sky, case))
    return [
        line("rtrace_radiance", "blended with the ground", np.stack(ours), np.stack(theirs)),
        line("rtrace_radiance", "not blended", np.stack(pure), np.stack(theirs)),
    ]


def integrals(folder: Path) -> list[Line]:
    """Eq. (3): against two other quadratures, and the program's sum of 145 points."""
    rows = rows_of(folder / "normalisation.csv")
    ours = perez.horizontal_integral(printed(rows), np.deg2rad(column(rows, "Z_deg")))
    exact, ratio = column(rows, "integral_f_cos"), column(rows, "ratio_145_point_sum")
    stress = rows_of(folder / "stress_normalisation.csv")
    epsilon = np.array([1.0, 1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 7.0])[column(stress, "bin").astype(int) - 1]
    zenith = np.deg2rad(column(stress, "Z_deg"))
    lit = zenith < np.pi / 2
    five = perez.coefficients(
        epsilon[lit], column(stress, "delta")[lit], np.minimum(zenith[lit], 1.5707), limits="paper"
    )
    hard = perez.horizontal_integral(five, zenith[lit])
    return [
        line("normalisation", "integral, eq. (3)", ours, exact),
        line("normalisation", "the programs' sum of 145 points", exact * ratio, exact),
        line("stress_normalisation", "integral, eq. (3)", hard, column(stress, "integral_f_cos")[lit]),
    ]


def patches(folder: Path) -> list[Line]:
    """patch_mass.csv: 10-degree patches, azimuths 0 to 180 degrees from the sun."""
    known = {row["case"]: row for row in rows_of(folder / "normalisation.csv")}
    rows = rows_of(folder / "patch_mass.csv")
    grid = PatchGrid.regular(9, 36)
    ours, theirs = [], []
    for case in (name for name in rows[0] if name in known):
        five, zenith = printed([known[case]])[0], float(np.deg2rad(float(known[case]["Z_deg"])))
        mass = PerezSky(sun_zenith_rad=zenith, coefficients=five).patch_mass(grid)
        ours.append(mass.reshape(9, 36)[:, :18].ravel())
        theirs.append(column(rows, case))
    return [line("patch_mass", "share of a patch", np.stack(ours), np.stack(theirs))]


def hard_cases(folder: Path) -> list[Line]:
    """hard_cases.csv: ln |f| without limits, b > 0 among them, where f is a float64; the signs of all must agree."""
    rows = rows_of(folder / "hard_cases.csv")
    five: dict[tuple[str, ...], dict[str, float]] = {}
    for row in rows:
        if row["quantity"] in FIVE and not row["exact_20_digits"].startswith("undefined"):
            key = (row["bin"], row["Z_deg"], row["delta"])
            five.setdefault(key, {})[row["quantity"]] = float(row["exact_20_digits"])
    lines = []
    for kind in ("b_positive", "negative_first_factor", "negative_second_factor", "d_positive"):
        ours, theirs = [], []
        for row in rows:
            values = five.get((row["bin"], row["Z_deg"], row["delta"]), {})
            if row["category"] == kind and row["quantity"] == "f" and np.isfinite(float(row["log_abs"])):
                sky, turned, sun = (np.deg2rad(float(row[name])) for name in ("xi_deg", "phi_deg", "Z_deg"))
                f = perez.relative_radiance(sky, turned, sun, [values[name] for name in FIVE])
                if int(np.sign(f)) != int(row["sign"]):
                    raise SystemExit(f"hard_cases.csv: the sign of f differs in {row}")
                if np.isfinite(f):
                    ours.append(math.log(abs(f)))
                    theirs.append(float(row["log_abs"]))
        lines.append(line("hard_cases", f"ln abs f, {kind.replace('_', ' ')}", np.array(ours), np.array(theirs)))
    return lines


def shares(epsilon: float, delta: float, sun: float) -> np.ndarray:
    """Share of the photons in 180 x 181 equal cells of sin^2(zenith angle) and azimuth."""
    zenith = np.arcsin(np.sqrt((np.arange(180) + 0.5) / 180))[:, None]
    azimuth = (np.arange(181) + 0.5) * np.pi / 181
    value = perez.relative_radiance(zenith, azimuth, sun, perez.coefficients(epsilon, delta, sun))
    return np.maximum(value, 0.0) / np.maximum(value, 0.0).sum()


def print_jumps() -> None:
    """Total variation between the skies on both sides of each border of the bins, at a typical Delta."""
    median = (0.18, 0.30, 0.31, 0.29, 0.25, 0.18, 0.14, 0.09)
    print("| border | Δ | Z = 20° | Z = 45° | Z = 70° |")
    print("| --- | --- | --- | --- | --- |")
    for k, border in enumerate(table.EPSILON_EDGES[1:]):
        delta = (median[k] + median[k + 1]) / 2
        cells = []
        for sun in np.deg2rad([20.0, 45.0, 70.0]):
            apart = shares(float(np.nextafter(border, 0)), delta, sun) - shares(border, delta, sun)
            cells.append(f"{np.abs(apart).sum() / 2:.3f}")
        print(f"| {border:g} | {delta:.3f} | {' | '.join(cells)} |")


def main() -> None:
    """Print the jumps between bins, and the differences where a folder is given."""
    print_jumps()
    if len(sys.argv) < 2:
        return
    folder = Path(sys.argv[1])
    lines = from_parameters(folder) + from_irradiance(folder) + radiances(folder) + blended(folder)
    lines += integrals(folder) + patches(folder) + hard_cases(folder)
    print("\n| table | quantity | values | largest difference | largest relative difference |")
    print("| --- | --- | --- | --- | --- |")
    for name, what, n, absolute, ratio in lines:
        print(f"| {name} | {what} | {n} | {absolute:.1e} | {ratio:.1e} |")


if __name__ == "__main__":
    main()
