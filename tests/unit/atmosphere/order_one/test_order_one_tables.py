"""Order 1 against the reference tables: spherical, plane-parallel, and those of the description's own tool."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Callable

import numpy as np
import pytest

from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.order_one import solve_order_one
from tests.reference.spherical import SlowRays
from tests.support.atmospheres import Layer, full, mol_ozone, molecules_only, plane_parallel, sample
from tests.support.shared import SHARED, needs_shared

TABLES = SHARED / "atmosphere"
MAKERS: dict[str, Callable[..., Medium]] = {"rayleigh": molecules_only, "mol_ozone": mol_ozone, "full": full}
SMALLEST_DIGIT = 5e-13  # of the printed radiances


def grouped(name: str, *keys: str) -> dict[tuple[str, ...], list[dict[str, str]]]:
    """Rows of a table by the values of some columns."""
    groups: dict[tuple[str, ...], list[dict[str, str]]] = defaultdict(list)
    with (TABLES / name).open() as file:
        for row in csv.DictReader(file):
            groups[tuple(row[key] for key in keys)].append(row)
    return groups


def column(rows: list[dict[str, str]], name: str) -> np.ndarray:
    return np.array([float(row[name]) for row in rows])


@needs_shared
def test_spherical_sun_up() -> None:
    n_rows = 0
    for (case, wavelength, sun_deg), rows in grouped(
        "spherical_radiance.csv", "case", "wavelength_nm", "sza_deg"
    ).items():
        if float(sun_deg) > 90:
            continue
        zenith, azimuth = np.radians(column(rows, "vza_deg")), np.radians(column(rows, "phi_deg"))
        found = solve_order_one(MAKERS[case](float(wavelength)), np.radians(float(sun_deg)), zenith, azimuth)[0]
        np.testing.assert_allclose(found, column(rows, "L_order1"), rtol=1e-5, atol=SMALLEST_DIGIT)
        n_rows += len(rows)
    assert n_rows == 840


@needs_shared
def test_spherical_sun_down() -> None:
    """At 92 degrees the table itself stops being good to 1e-4: its quadrature steps over the edge of the shadow.

    The rows in which we differ from it by more are compared with a slow quadrature that is cut there.
    """
    others = 0
    for (case, wavelength, sun_deg), rows in grouped(
        "spherical_radiance.csv", "case", "wavelength_nm", "sza_deg"
    ).items():
        if float(sun_deg) <= 90:
            continue
        zenith, azimuth = np.radians(column(rows, "vza_deg")), np.radians(column(rows, "phi_deg"))
        medium, expected = MAKERS[case](float(wavelength)), column(rows, "L_order1")
        found = solve_order_one(medium, np.radians(92.0), zenith, azimuth)[0]
        np.testing.assert_allclose(found, expected, rtol=7e-3, atol=SMALLEST_DIGIT)
        off = np.flatnonzero(np.abs(found - expected) > 1e-4 * expected + SMALLEST_DIGIT)
        others += off.size
        if off.size:
            worst = off[np.argmax(np.abs(found - expected)[off] / expected[off])]
            slow = SlowRays(medium, (1e3, 4e3, 8e3, 15e3, 21.5e3, 30e3, 39e3, 60e3))
            exact = slow.radiance(np.radians(92.0), float(zenith[worst]), float(azimuth[worst]))
            assert found[worst] == pytest.approx(exact, rel=1e-6)
    assert others <= 45


@needs_shared
def test_plane_parallel_layers() -> None:
    layers: dict[str, list[Layer]] = defaultdict(list)
    for (case, _), [row] in grouped("pp_layers_cases.csv", "case", "layer_from_top").items():
        layers[case].append(
            Layer(**{k: float(row[k]) for k in ("tau_rayleigh", "tau_hg", "g", "omega_hg", "tau_absorber")})
        )
    for (case, mu0), rows in grouped("pp_layers_radiance.csv", "case", "mu0").items():
        zenith, azimuth = np.arccos(column(rows, "mu")), np.radians(column(rows, "phi_deg"))
        found = solve_order_one(plane_parallel(layers[case]), float(np.arccos(float(mu0))), zenith, azimuth)[0]
        claimed = 1e-4 if case == "L3" else 1e-5
        np.testing.assert_allclose(found, column(rows, "L_order1"), rtol=claimed, atol=5e-10)


@needs_shared
def test_plane_parallel_rayleigh() -> None:
    for (tau, mu0), rows in grouped("pp_rayleigh_orders.csv", "tau", "mu0").items():
        zenith, azimuth = np.arccos(column(rows, "mu")), np.radians(column(rows, "phi_deg"))
        medium = plane_parallel([Layer(tau_rayleigh=float(tau))])
        found = solve_order_one(medium, float(np.arccos(float(mu0))), zenith, azimuth)[0]
        np.testing.assert_allclose(found, column(rows, "L_order1"), rtol=1e-5, atol=5e-10)


@needs_shared
@pytest.mark.parametrize(("name", "maker"), [("calcmysky_rayleigh", molecules_only), ("calcmysky_sample", sample)])
def test_the_tool(name: str, maker: Callable[..., Medium]) -> None:
    """Within 0.5 %, or 1e-5 of the brightest where it is dark, but along the horizon with the sun below it.

    There the tool's sun, a disc, still stands in part above the horizon of the air that is seen; ours is a point.
    """
    n_rows = 0
    for (wavelength, mu0), rows in grouped(f"{name}.csv", "wavelength_nm", "mu0").items():
        sun = float(np.arccos(float(mu0)))
        view, cosine = column(rows, "mu_view"), column(rows, "cos_view_sun")
        zenith = np.arccos(np.clip(view, -1, 1))
        across = np.sin(zenith) * np.sin(sun)
        turn = np.divide(cosine - view * np.cos(sun), across, out=np.ones_like(across), where=across > 1e-9)
        found = solve_order_one(maker(float(wavelength)), sun, zenith, np.arccos(np.clip(turn, -1, 1)))[0]
        expected = column(rows, "L_order1")
        keep = (view > 0.1) | (float(mu0) > 0.0)
        np.testing.assert_allclose(found[keep], expected[keep], rtol=5e-3, atol=1e-5 * expected.max())
        n_rows += int(keep.sum())
    assert n_rows > 500
