"""Photons that repeat another: counted exactly, in bounded memory, and by the same sample in any order of blocks."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.directions import Frame
from aomc_sky.verify import repeats
from aomc_sky.verify.repeats import RepeatFinder, RepeatSample
from tests.support.shared import INPUTS

FINDER = RepeatFinder(beams=np.zeros((0, 2)))


def sample_of(rows, finder=FINDER):
    return finder.sample(rows.astype(np.float64))


def directions(n, seed=0):
    rng = np.random.default_rng(seed)
    zenith, azimuth = np.arcsin(np.sqrt(rng.random(n))), 2 * np.pi * rng.random(n)
    sine = np.sin(zenith)
    return -np.column_stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)]).astype(np.float32)


def brute(rows):
    """Pairs of a square and equal pairs, one by one."""
    squares = np.floor((rows[:, :2].astype(np.float64) + 1) * 2**17)
    n = len(rows)
    near = sum(int((squares[k + 1 :] == squares[k]).all(axis=1).sum()) for k in range(n))
    return near, sum(int((rows[k + 1 :] == rows[k]).all(axis=1).sum()) for k in range(n))


def test_pairs_are_counted_exactly():
    rows = directions(800)
    rows[100:110] = rows[50]  # 11 of one direction: 55 pairs
    rows[200] = rows[201]
    rows[300] = rows[301] * np.float32([1 + 2e-7, 1, 1])  # a neighbour
    rows[400] = rows[401] * [1, 1, -1]  # of another sign of z: another direction
    rows[500] = np.where(rows[500] == 0, -0.0, rows[500])
    near, equal = brute(rows)
    assert equal == 56
    assert sample_of(rows).pairs() == (near, equal)


def test_one_equal_pair_of_neighbours_has_the_chance_of_a_neighbour():
    """1 / 64, as the documentation says."""
    assert sample_of(np.repeat(directions(1), 2, axis=0)).check(1).p_value == pytest.approx(1 / 64, rel=1e-12)


def test_zeros_of_both_signs_and_damaged_directions():
    rows = np.array([[0.0, -0.0, -1.0], [-0.0, 0.0, -1.0]])
    assert sample_of(rows).pairs() == (1, 1)
    rows = directions(10)
    rows[3:6] = np.nan
    rows[7] = [np.inf, 3.0, -1e30]
    assert sample_of(rows).pairs() == (0, 0)
    rows[7:9] = [5.0, -7.0, 1.0]
    assert sample_of(rows).pairs() == (1, 1)


def test_of_many_photons_those_of_some_squares_are_kept(monkeypatch):
    """A pair is kept or lost as a whole, memory is bounded, and the sample does not depend on the blocks."""
    monkeypatch.setattr(repeats, "MAX_KEPT", 10_000)
    rows = directions(200_000)
    rows[100_000:] = rows[:100_000]
    totals = []
    for size in (7_000, 50_000):
        total = RepeatSample()
        for start in range(0, len(rows), size):
            total = total + sample_of(rows[start : start + size])
            assert sum(part.size for part in total.parts) <= 10_000
        totals.append(total)
    assert totals[0].pairs() == totals[1].pairs()
    assert totals[0].halvings == totals[1].halvings > 3
    check = totals[0].check(1)
    assert check.found == pytest.approx(0.5, rel=0.05)  # some 5000 pairs: 1.4 % of them
    assert check.p_value == 0.0


def test_the_part_of_the_sky_is_a_random_one():
    """Halving keeps half of the photons of every sector, within 5 standard deviations."""
    rows = directions(400_000)
    word = sample_of(rows).parts[0]
    kept = word >> np.uint64(63) == 0
    sector = np.floor((np.arctan2(rows[:, 1], rows[:, 0]) + np.pi) / (2 * np.pi) * 63.999).astype(int)
    n_kept, in_all = np.bincount(sector, kept, 64), np.bincount(sector, minlength=64)
    assert (np.abs(n_kept - in_all / 2) < 5 * np.sqrt(in_all / 4)).all()


def test_beams_are_left_out():
    grid = sky.DirectBeam(sun_zenith_deg=30.0, sun_azimuth_deg=70.0).lower([500.0])
    for frame in (Frame.UP, Frame.DOWN):
        finder = RepeatFinder.of(grid, frame, is_centred=False)
        rows = directions(500)
        rows[:100] = sky.directions.travel_from_sky(30.0, 70.0, frame)
        rows[:50, 0] += 1e-7  # rounding
        assert sample_of(rows, finder).n == 400
        assert sample_of(rows, finder).pairs()[1] == 0


def test_skies_of_few_directions_are_not_tested(monkeypatch):
    uniform = sky.UniformSky().lower([500.0])
    assert "one direction" in RepeatFinder.of(uniform, Frame.UP, is_centred=True)
    pytest.importorskip("h5py")
    night = sky.read_scene(INPUTS / "night_sky" / "amc.inp", iterations=10).source().components
    assert isinstance(RepeatFinder.of(night, Frame.UP, is_centred=False), RepeatFinder)
    monkeypatch.setattr(repeats, "_LEAST_WIDTH", 0.6)
    assert "is narrower than 0.6 rad" in RepeatFinder.of(night, Frame.UP, is_centred=False)
