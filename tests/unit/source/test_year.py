"""The plan of a year: which hours have a sky, what changes its name, and what it refuses."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.errors import AomcSkyError, SceneError, UsageError
from aomc_sky.formats.weather import read_weather
from aomc_sky.source.light.sun_position import sun_position
from aomc_sky.source.year import HourState, YearPlan, plan_year, state_text

pytest.importorskip("pvlib")

GOOD = Path(__file__).resolve().parents[2] / "data" / "weather" / "good"


@pytest.fixture(scope="module")
def table():
    return read_weather(GOOD / "invented.epw", "epw")


def changed(table, **columns):
    """The table with other values in a row: name=(row, value)."""
    arrays = {}
    for name, (row, value) in columns.items():
        arrays[name] = getattr(table, name).copy()
        arrays[name][row] = value
    return dataclasses.replace(table, **arrays)


def test_states_of_the_hours(table):
    plan = plan_year(changed(table, dhi=(11, 0.0), is_missing=(12, True)), iterations=100)
    sun = sun_position(table.midpoint, table.latitude_deg, table.longitude_deg)
    states = [HourState(int(state)) for state in plan.arrays["state"]]
    for row, zenith in enumerate(sun.apparent_zenith_deg):
        wanted = HourState.SKY if table.dhi[row] > 0 and row != 11 else HourState.NO_DIFFUSE
        wanted = HourState.NIGHT if zenith >= 90 else HourState.MISSING if row == 12 else wanted
        assert states[row] is wanted
    assert plan.sky_rows.size == 30
    risen = (sun.zenith_deg >= 90) & (sun.apparent_zenith_deg < 90)  # seen, though its centre is below the horizon
    assert risen.sum() == 2
    assert [state_text(state) for state in HourState] == ["sky", "night", "no-diffuse", "missing"]


def test_the_sun_of_an_hour_is_that_of_its_middle(table):
    plan = plan_year(table, iterations=100)
    sun = sun_position(table.start + np.timedelta64(1800, "s"), table.latitude_deg, table.longitude_deg)
    assert plan.arrays["sun_zenith_deg"] == pytest.approx(sun.apparent_zenith_deg, abs=1e-9)
    assert plan.arrays["sun_azimuth_deg"] == pytest.approx(sun.azimuth_deg, abs=1e-9)
    sky = plan.sky(12)
    assert sky.sun_zenith_rad == pytest.approx(np.deg2rad(sun.apparent_zenith_deg[12]), abs=1e-10)
    assert sky.extraterrestrial_normal == pytest.approx(sun.extraterrestrial_normal[12], abs=1e-6)
    assert (sky.dni, sky.dhi) == (table.dni[12], table.dhi[12])


def test_everything_that_changes_photons_changes_the_name(table):
    plans = [
        plan_year(table, iterations=100),
        plan_year(table, iterations=101),
        plan_year(table, iterations=100, seed=1),
        plan_year(table, iterations=100, bins=(9, 36)),
        plan_year(table, iterations=100, limits="paper"),
        plan_year(table, iterations=100, air_mass="kasten-1966"),
        plan_year(table, iterations=100, with_beam=True),
        plan_year(changed(table, dhi=(12, 77.0)), iterations=100),
        plan_year(changed(table, dni=(12, 77.0)), iterations=100),
        plan_year(dataclasses.replace(table, longitude_deg=13.23), iterations=100),
    ]
    assert len({plan.sha256 for plan in plans}) == len(plans)
    assert plan_year(dataclasses.replace(table, path="elsewhere.epw"), iterations=100).sha256 == plans[0].sha256


def test_saved_and_read_back(table, tmp_path):
    plan = plan_year(table, iterations=100, with_beam=True)
    path = tmp_path / "plan.npz"
    path.write_bytes(plan.to_bytes())
    again = YearPlan.load(path)
    assert again.sha256 == plan.sha256
    assert again.options == plan.options
    assert not again.arrays["dni"].flags.writeable
    assert (again.n_cells, again.grid.n_patches, again.iterations) == (8101, 8100, 100)


@pytest.mark.parametrize("damage", ["empty", "cut", "foreign", "absent"])
def test_a_file_that_is_no_plan_of_a_year(damage, table, tmp_path):
    path = tmp_path / "plan.npz"
    data = plan_year(table, iterations=100).to_bytes()
    if damage == "foreign":
        np.savez(path, options=np.frombuffer(b'{"schema": "another", "stream": "aomc-sky/2"}', dtype=np.uint8))
    elif damage != "absent":
        path.write_bytes(b"" if damage == "empty" else data[: len(data) // 2])
    with pytest.raises(AomcSkyError, match=r"plan\.npz"):
        YearPlan.load(path)


def test_what_is_refused(table):
    for iterations in (0, -1, 2**62 + 1):
        with pytest.raises(UsageError, match="iterations"):
            plan_year(table, iterations=iterations)
    with pytest.raises(SceneError, match=r"row 1 .* night"):
        plan_year(table, iterations=1).sky(0)
    with pytest.raises(UsageError, match="seed"):
        plan_year(table, iterations=1, seed=-1)


def test_share_of_the_beam(table):
    plan = plan_year(table, iterations=100, with_beam=True)
    direct = table.dni[12] * np.cos(np.deg2rad(plan.arrays["sun_zenith_deg"][12]))
    assert plan.direct_fraction(12) == pytest.approx(direct / (direct + table.dhi[12]), rel=1e-14)
    assert plan_year(table, iterations=100).direct_fraction(12) == 0.0
