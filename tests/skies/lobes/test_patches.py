"""Masses of patches: sums, closed forms, plain quadrature, the reference table."""

import dataclasses

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.skies.lobes import functions as lobes
from aomc_sky.skies.lobes.lobe import rotation_matrix
from aomc_sky.skies.lobes.patches import TiltedLobe

GRID = sky.PatchGrid.regular(9, 12)
UP = (1.0, 0.0, 0.0, 0.0)
TILTED = (0.9, 0.4, 0.1, 0.3)
ON_HORIZON = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
DOWN = (0.3, 0.9, 0.2, 0.1)
SHAPES = [
    *(("hg", g, 0.0) for g in (0.0, 1e-8, 0.9, 1 - 2**-24)),
    *(("ggx", *alpha) for alpha in ((0.3, 1.2), (1e-4, 1e-4), (1e3, 1e3), (1e-2, 1e2))),
    *(("beckmann", *alpha) for alpha in ((0.3, 1.2), (1e-4, 1e-4), (1e-2, 1e2))),
]
TURNS = (UP, TILTED, ON_HORIZON, DOWN)
"""Each shape has two of them by default, and each of them half of the shapes."""


@pytest.mark.parametrize(
    ("shape", "quaternion"),
    [
        pytest.param(shape, turn, marks=() if (i + j) % 4 < 2 else pytest.mark.slow)
        for i, shape in enumerate(SHAPES)
        for j, turn in enumerate(TURNS)
    ],
)
def test_patches_add_up_to_the_mass_above_the_horizon(shape, quaternion):
    """Two computations that share nothing but the density."""
    mass = lobes.patch_mass(*shape, quaternion, GRID)
    narrow, ratio = (1 - shape[1], 1.0) if shape[0] == "hg" else (min(shape[1:]), max(shape[1:]) / min(shape[1:]))
    # each cell adds four edges, and the edges of a ring, or of a meridian, make at most one whole turn together;
    # on the horizon an edge passes through the axis: its place, rounded, counts in units of the width
    rounding = 4 * 2 * (GRID.n_zenith + GRID.n_azimuth + 2) * 2.0**-53
    allowed = rounding + 1e-16 * ratio + (1e-16 / narrow if quaternion == ON_HORIZON else 0.0)
    assert mass.shape == (GRID.n_patches,)
    assert mass.min() >= 0
    assert mass.sum() == pytest.approx(float(lobes.mass_above_horizon(*shape, quaternion)), abs=allowed)


MODERATE = [("hg", 0.5, 0.0), ("hg", 0.9, 0.0), ("ggx", 0.3, 1.2), ("beckmann", 0.3, 1.2), ("beckmann", 1.0, 1.0)]


@pytest.mark.parametrize("weighting", ["plain", "projected"])
@pytest.mark.parametrize("shape", MODERATE)
def test_each_patch_by_quadrature(shape, weighting):
    """48 x 48 Gauss points; the kink at the horizon of a GGX lobe limits them, so those patches are left out."""
    nodes, weights = np.polynomial.legendre.leggauss(48)
    zenith, azimuth = np.deg2rad(GRID.zenith_bounds_deg), np.deg2rad(GRID.azimuth_bounds_deg)
    z, a = (angle[:, :1] + np.diff(angle) * (nodes + 1) / 2 for angle in (zenith, azimuth))
    z, a = z[:, None, :, None], a[None, :, None, :]
    world = np.stack(np.broadcast_arrays(np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)), axis=-1)
    local = lobes.to_local(TILTED, world)
    value = lobes.pdf(*shape, local) * np.sin(z) * (np.cos(z) if weighting == "projected" else 1.0)
    area = np.diff(zenith) * np.diff(azimuth).T / 4
    true = (np.einsum("zaij,i,j->za", value, weights, weights) * area).ravel()
    whole = (local[..., 2] > 0).all(axis=(2, 3)).ravel() | (shape[0] == "hg")
    assert whole.sum() > 50
    mass = lobes.patch_mass(*shape, TILTED, GRID, weighting=weighting)
    assert mass[whole] == pytest.approx(true[whole], rel=1e-12, abs=1e-13 if weighting == "projected" else 2e-15)


@pytest.mark.parametrize(
    ("shape", "error"),
    [
        (("beckmann", 20.0, 20.0), 1e-12),
        (("ggx", 100.0, 100.0), 1e-12),
        (("hg", 0.999, 0.0), 1e-13),
        (("ggx", 0.02, 0.6), 1e-12),
        (("beckmann", 0.01, 100.0), 1e-9),
        (("hg", 1 - 1e-14, 0.0), 1e-13),
        (("ggx", 9e-4, 3e-4), 1e-13),
        (("beckmann", 4e-4, 4e-4), 1e-13),
    ],
)
def test_projected_patches_of_extreme_lobes_add_up(shape, error):
    mass = lobes.patch_mass(*shape, TILTED, GRID, weighting="projected")
    true = float(lobes.mass_above_horizon(*shape, TILTED, weighting="projected"))
    assert mass.sum() == pytest.approx(true, abs=error)


def test_closed_forms():
    """Isotropic light: solid angles over 4 pi. A round GGX lobe of alpha 1 overhead: the cosine law."""
    for weighting, area in (("plain", GRID.solid_angle_sr), ("projected", GRID.projected_solid_angle_sr)):
        mass = lobes.patch_mass("hg", 0.0, 0.0, TILTED, GRID, weighting=weighting)
        assert mass == pytest.approx(area / (4 * np.pi), abs=2e-15)
    mass = lobes.patch_mass("ggx", 1.0, 1.0, UP, GRID)
    assert mass == pytest.approx(GRID.projected_solid_angle_sr / np.pi, abs=2e-15)


@pytest.mark.parametrize("shape", MODERATE)
def test_a_needle_of_patches_and_grids_with_gaps(shape):
    """A finer grid adds up to a coarser one; patches without extent have no mass; columns may start below 0."""
    fine = lobes.patch_mass(*shape, TILTED, sky.PatchGrid.regular(18, 24)).reshape(9, 2, 12, 2).sum(axis=(1, 3))
    coarse = lobes.patch_mass(*shape, TILTED, GRID)
    assert fine.ravel() == pytest.approx(coarse, abs=4e-15)
    some = sky.PatchGrid(zenith_bounds_deg=[[20, 30], [40, 40], [50, 70]], azimuth_bounds_deg=[[-30, 0], [60, 120]])
    got = lobes.patch_mass(*shape, TILTED, some).reshape(3, 2)
    table = coarse.reshape(9, 12)
    expected = [[table[2, 11], table[2, 2:4].sum()], [0, 0], [table[5:7, 11].sum(), table[5:7, 2:4].sum()]]
    assert got == pytest.approx(np.array(expected), abs=4e-15)


def test_a_ridge_between_the_points_is_not_seen_without_its_pilot(monkeypatch):
    """Planted: Beckmann's ridge is e^-600 at all points of a patch, and two orders agree on nothing."""
    shape = ("beckmann", 1e-2, 1e2)
    lobe = TiltedLobe(kind=shape[0], param0=shape[1], param1=shape[2], rotation=rotation_matrix(TILTED))
    blind = dataclasses.replace(lobe.rule("plain"), pilot=None)
    monkeypatch.setattr(TiltedLobe, "rule", lambda *_: blind)
    mass = lobes.patch_mass(*shape, TILTED, GRID)
    assert abs(mass.sum() - float(lobes.mass_above_horizon(*shape, TILTED))) > 0.1
