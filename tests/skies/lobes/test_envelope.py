"""Envelopes of the lobes' samplers: rigorous bounds, no light left out, few tries; lobes as components."""

import itertools

import numpy as np
import pytest

from aomc_sky.component import Law
from aomc_sky.errors import SceneError
from aomc_sky.skies.lobes import envelope as envelope_module
from aomc_sky.skies.lobes import functions as lobes
from aomc_sky.skies.lobes.envelope import LobeFrame, envelopes_of
from aomc_sky.skies.lobes.horizon import masses_of_lobe
from aomc_sky.skies.lobes.lobe import vertical_in_local
from tests.support.fairness import turned
from tests.support.lobes import lobe_components

WIDTHS = [(1e-4, 1e-4), (0.01, 0.02), (0.3, 0.3), (1.0, 1.0), (1e3, 1e3), (0.01, 100.0), (1e-4, 1.0), (0.1, 1e3)]
SHAPES = [
    *(("hg", g, 0.0) for g in (0.0, 1e-8, 0.5, 0.9, 0.99, 1 - 2.0**-24, 1 - 1e-10, 1 - 1e-14)),
    *((kind, *widths) for kind in ("ggx", "beckmann") for widths in WIDTHS),
]
ZENITHS = (0.0, 10.0, 60.0, 80.0, 89.0, 89.999, 90.0, 90.0001, 91.0, 95.0, 120.0, 170.0, 179.9, 180.0)
EVERY = list(itertools.product(SHAPES, ZENITHS))
FEW = EVERY[::17]


def envelope(shape, zenith_deg):
    """Frame, cells, total and projected mass of a lobe; None where nothing is above the horizon."""
    quaternion = np.array(turned(zenith_deg, roll_deg=35.0))
    projected = float(lobes.mass_above_horizon(*shape, quaternion, weighting="projected"))
    if not projected > 1e-200:
        return None
    frame = LobeFrame.of(*shape, quaternion)
    return frame, *envelopes_of([frame])[0], projected


def places(cells, rng):
    """A random place in each bin of each cell."""
    b0, width, a0, count, half, t0, t1, bound = np.repeat(cells, cells[:, 3].astype(int), axis=0).T
    x = rng.random(b0.size) * count
    psi = np.arctan2(t0, t1) / (np.pi / 2) + half * (2 * rng.random(b0.size) - 1)
    return a0 + width * (count - x), b0 + width * x, psi, bound


@pytest.mark.parametrize("case", [pytest.param(c, marks=() if c in FEW else pytest.mark.slow) for c in EVERY])
def test_bounds_hold_and_tries_are_few(case):
    found = envelope(*case)
    if found is None:
        return
    frame, cells, total, projected = found
    assert 1.0 - 1e-6 < total / projected < 3.0
    count = cells[:, 3].sum()
    assert count == 2 ** int(np.log2(count))
    np.testing.assert_allclose(cells[:, 7] * cells[:, 1] * cells[:, 4] / 2, total / count, rtol=1e-12)
    rng = np.random.default_rng(1)
    for _ in range(4):
        a, b, psi, bound = places(cells, rng)
        assert np.all(frame.cosine(a, b, psi) <= bound)


@pytest.mark.parametrize("case", FEW)
def test_no_light_is_left_out(case):
    """Where a lobe shines above the horizon there is one cell, and only one."""
    found = envelope(*case)
    if found is None:
        return
    frame, cells, _, _ = found
    rng = np.random.default_rng(2)
    b = rng.random(3000) * min(1.0, 1.01 * frame.largest_share())
    psi = rng.uniform(-2, 2, b.size)
    lit = frame.cosine(1 - b, b, psi) > 0
    centre = np.arctan2(cells[:, 5], cells[:, 6]) / (np.pi / 2)
    in_b = (b[:, None] >= cells[:, 0]) & (b[:, None] < cells[:, 0] + cells[:, 1] * cells[:, 3])
    inside = in_b & (np.abs(psi[:, None] - centre) < cells[:, 4])
    assert np.all(inside.sum(axis=1)[lit] == 1)
    assert lit.any()


@pytest.mark.parametrize("kind", ["hg", "ggx", "beckmann"])
def test_lobes_that_are_made_together_are_those_made_alone(kind):
    cases = [(shape, zenith_deg) for shape, zenith_deg in EVERY[::5] if shape[0] == kind]
    found = [(case, alone) for case in cases if (alone := envelope(*case)) is not None]
    assert len(found) > 10
    for some in (found, found[::-1], found[3:7]):
        together = envelopes_of([frame for _, (frame, *_) in some])
        for (_, (_, cells, total, _)), (batch_cells, batch_total) in zip(some, together, strict=True):
            assert cells.tobytes() == batch_cells.tobytes()
            assert total == batch_total
    assert envelopes_of([]) == []


def test_a_shifted_bound_would_be_seen():
    frame, cells, _, _ = envelope(("ggx", 0.3, 0.3), 60.0)
    a, b, psi, bound = places(cells, np.random.default_rng(1))
    assert np.any(frame.cosine(a, b, psi) > 0.95 * bound)


def test_mean_cosine_closed_forms():
    for zenith_deg in (0.0, 50.0, 90.0, 140.0):
        quaternion = turned(zenith_deg)
        projected = float(lobes.mass_above_horizon("hg", 0.0, 0.0, quaternion, weighting="projected"))
        squared = masses_of_lobe("hg", 0.0, 0.0, vertical_in_local(quaternion))[2]
        assert squared / projected == pytest.approx(2 / 3, rel=1e-12)
    squared = masses_of_lobe("ggx", 1.0, 1.0, vertical_in_local(turned(0.0)))[2]
    assert squared / (2 / 3) == pytest.approx(0.75, rel=1e-9)


def lower(**changed):
    given = {
        "names": ["stars", "city", "sunken"],
        "kinds": ["hg", "ggx", "beckmann"],
        "param0": [0.0, 0.2, 0.2],
        "param1": [0.0, 0.4, 0.2],
        "quaternion": [[1, 0, 0, 0], turned(80.0), turned(179.0)],
        "irradiance": [[1.0, 2.0], [3.0, 0.0], [1.0, 1.0]],
    }
    return lobe_components(**(given | changed))


def test_components():
    stars, city = lower()  # of the third nothing is left: exp(-(57 / 0.2)^2)
    assert (stars.law, city.law) == (Law.HG, Law.GGX)
    np.testing.assert_allclose(stars.strength, [0.25, 0.5], rtol=1e-13)
    np.testing.assert_array_equal(stars.irradiance_W_m2_nm, stars.strength)
    assert stars.below_horizon == pytest.approx(0.5, rel=1e-13)
    above = lobes.mass_above_horizon("ggx", 0.2, 0.4, turned(80.0))
    projected = lobes.mass_above_horizon("ggx", 0.2, 0.4, turned(80.0), weighting="projected")
    assert city.below_horizon == pytest.approx(1 - above, rel=1e-12)
    np.testing.assert_allclose(city.strength, [3 * projected, 0.0])
    assert city.cell[0, 2] == pytest.approx(above / projected, rel=1e-13)
    assert [c.name for c in lower(irradiance=[[0.0], [1.0], [1.0]])] == ["city"]
    twins = lower(kinds=["hg"] * 3, param0=[0.5] * 3, param1=[0.0] * 3, quaternion=[turned(100.0)] * 3)
    assert len(twins) == 3
    assert twins[0].bounds is twins[2].bounds or np.shares_memory(twins[0].bounds, twins[2].bounds)


@pytest.mark.parametrize(
    ("changed", "error", "text"),
    [
        ({"names": ["a;", "b", "a,"]}, SceneError, "must differ"),
        ({"irradiance": [[1.0], [-1.0], [1.0]]}, SceneError, "not negative"),
        ({"param0": [1.0, 0.1, 0.1]}, SceneError, "0 <= g < 1"),
    ],
)
def test_bad_lobes(changed, error, text):
    with pytest.raises(error, match=text):
        lower(**changed)


ENDS = {
    "no cell wastes much": ({"_CELLS_IN_SIGHT": 1e-9}, True),
    "all cells waste little": ({"_CELLS_IN_SIGHT": 1e9, "_WASTE": 10.0}, True),
    "enough cells": ({"_MAX_CELLS": 3}, True),
    "no pass is left": ({"_MAX_PASSES": 0}, True),
    "one cell may come": ({"_MAX_CELLS": 4, "_MAX_PASSES": 1}, False),
    "none of them": ({}, False),
}


@pytest.mark.parametrize(("changed", "is_whole"), ENDS.values(), ids=ENDS)
def test_each_reason_alone_ends_the_refinement(changed, is_whole, monkeypatch):
    """All lobes begin with four cells, one in each quarter turn."""
    for name, value in changed.items():
        monkeypatch.setattr(envelope_module, name, value)
    (cells, _), _ = envelopes_of([LobeFrame.of("ggx", 0.3, 0.6, np.array(turned(30.0)))] * 2)
    assert (len(cells) == 4) == is_whole
