"""Photons inside one cell, placed by Philox: uniform in mu^2 (or mu) and in azimuth."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from tests.support import chi2
from tests.support.sampled import (
    azimuth_place,
    cell_component,
    clipped,
    even,
    scene,
    sky_angles,
    square_counts,
    zenith_place_mu,
    zenith_place_mu2,
)

N = 200_000
CELLS = {
    "zenith": ((0.0, 1.0), (10.0, 11.0)),
    "middle": ((44.0, 45.0), (300.0, 310.0)),
    "horizon": ((89.0, 90.0), (180.0, 181.0)),
    "seam": ((30.0, 40.0), (-5.0, 5.0)),
    "dome": ((0.0, 90.0), (0.0, 360.0)),
}
PLACE = {Law.CELL_MU2: zenith_place_mu2, Law.CELL_MU: zenith_place_mu}


def places(law, cell, angles):
    """Both coordinates in the cell; float32 resolves 2e-5 of the width of one degree."""
    mu, sin2, azimuth = angles
    zenith, columns = CELLS[cell]
    return clipped(PLACE[law](mu, sin2, zenith), 1e-3), clipped(azimuth_place(azimuth, columns), 1e-3)


def p_values(s, t):
    return chi2.ks_p(s), chi2.ks_p(t), chi2.chi2_p(np.ravel(square_counts(s, t)), even(s.size, 256))


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("law", PLACE)
def test_place_in_the_cell(plan, law, cell, precision):
    source = scene(cell_component(law, *CELLS[cell]), N).source(seed=1, placement="philox", precision=precision)
    s, t = places(law, cell, sky_angles(source.photons()))
    for p_value in p_values(s, t):
        plan.check(p_value)


def test_digits_below_the_24th(plan):
    """float64 photons carry 53 bits: what a 24-bit number leaves at zero is as random as the rest."""
    dome = scene(cell_component(Law.CELL_MU2, *CELLS["dome"]), N)
    mu, sin2, azimuth = sky_angles(dome.source(seed=2, placement="philox", precision="float64").photons())
    for u in (sin2, azimuth / 360):
        plan.check(chi2.ks_p(np.mod(u * 2.0**24, 1.0)))
    coarse = np.floor(np.random.default_rng(1).random(N) * 2**24) / 2**24
    mu = np.sqrt(1 - coarse)
    plan.catches(chi2.ks_p(np.mod((1 - mu * mu) * 2.0**24, 1.0)))


def planted(law, cell, defect, n=N):
    """Angles of photons with a defect, by another generator."""
    zenith_deg, (start, end) = CELLS[cell]
    u, v = np.random.default_rng(5).random((2, n))

    def between(function, step=0.0):
        near, far = function(np.deg2rad(np.add(zenith_deg, step)))
        return near * (1 - u) + far * u

    zenith = {
        "no sine": between(np.array),
        "cosine for cosine squared": np.arccos(between(np.cos)),
        "cosine squared for cosine": np.arcsin(np.sqrt(between(lambda z: np.sin(z) ** 2))),
        "edge off by one": np.arcsin(np.sqrt(between(lambda z: np.sin(z) ** 2, step=1.0))),
    }
    right = "cosine squared for cosine" if law is Law.CELL_MU2 else "cosine for cosine squared"
    theta = zenith.get(defect, zenith[right])
    azimuth = start + (end - start) * v
    spoilt = {
        "azimuth mirrored": -azimuth,
        "column off by one": azimuth + (end - start),
        "photons from the sea": azimuth + 180,
        "both from one number": start + (end - start) * u,
    }
    return np.cos(theta), np.sin(theta) ** 2, np.mod(spoilt.get(defect, azimuth), 360)


@pytest.mark.parametrize(
    ("law", "cell", "defect"),
    [
        (Law.CELL_MU2, "zenith", "no sine"),
        (Law.CELL_MU2, "horizon", "no sine"),
        (Law.CELL_MU, "dome", "no sine"),
        (Law.CELL_MU2, "horizon", "cosine for cosine squared"),
        (Law.CELL_MU2, "dome", "cosine for cosine squared"),
        (Law.CELL_MU, "horizon", "cosine squared for cosine"),
        (Law.CELL_MU, "seam", "cosine squared for cosine"),
        (Law.CELL_MU2, "middle", "edge off by one"),
        (Law.CELL_MU2, "seam", "edge off by one"),
        (Law.CELL_MU2, "middle", "azimuth mirrored"),
        (Law.CELL_MU2, "seam", "column off by one"),
        (Law.CELL_MU2, "middle", "photons from the sea"),
        (Law.CELL_MU2, "dome", "both from one number"),
    ],
)
def test_planted_defects(plan_only, law, cell, defect):
    plan_only.catches(min(p_values(*places(law, cell, planted(law, cell, defect)))))


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_beam_is_one_direction(precision):
    beam = scene(sky.DirectBeam(sun_zenith_deg=35, sun_azimuth_deg=110), 1000)
    (found,) = np.unique(beam.source(precision=precision).photons().directions, axis=0)
    zenith, azimuth = np.deg2rad([35, 110])
    true = (-np.sin(zenith) * np.cos(azimuth), -np.sin(zenith) * np.sin(azimuth), -np.cos(zenith))
    assert found == pytest.approx(true, abs=float(np.finfo(precision).eps))


def test_the_plant_itself_is_sound(plan_only):
    """Without a defect the other generator's photons pass, so what is caught is the defect."""
    for law in PLACE:
        for cell in CELLS:
            assert min(p_values(*places(law, cell, planted(law, cell, "none")))) >= plan_only.level
