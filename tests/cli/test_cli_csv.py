"""``info RUN --csv``: the irradiance of each component in each waveband, as the scene has it."""

import csv
import io

import numpy as np
import pytest

import aomc_sky as sky


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_irradiances_and_shares_are_those_of_the_scene(tmp_path, told):
    beam = sky.DirectBeam(sun_zenith_deg=40, irradiance_W_m2_nm=[0.3, 1.0, 0.2])
    diffuse = sky.UniformSky(irradiance_W_m2_nm=[0.1, 0.5, 0.4])
    scene = sky.Scene(wavebands=[440.0, 550.0, 670.0], n_photons=[90, 0, 80], components=[beam, diffuse])
    sky.write_run(scene, tmp_path / "run", formats=())
    rows = rows_of(told("info", tmp_path / "run", "--csv").out)
    assert [row["waveband"] for row in rows] == ["1", "3"]
    for row, band in zip(rows, (0, 2), strict=True):
        parts = scene.irradiance.of_component[band]
        names = [component.name for component in scene.components]
        assert [float(row[f"{name}_W_m2_nm"]) for name in names] == parts.tolist()
        np.testing.assert_allclose([float(row[f"{name}_share"]) for name in names], parts / parts.sum(), rtol=1e-15)
        assert float(row["irradiance_W_m2_nm"]) == pytest.approx(parts.sum(), rel=1e-15)


def test_relative_light_has_shares_alone(scene, tmp_path, told):
    told("run", scene, "--format", "none", "--out", tmp_path / "run")
    for row in rows_of(told("info", tmp_path / "run", "--csv").out):
        assert (row["sky_share"], row["sky_W_m2_nm"], row["irradiance_W_m2_nm"]) == ("1.0", "", "")


def test_a_table_is_that_of_a_finished_run(scene, tmp_path, told):
    assert "--csv is for a run" in told("info", scene, "--csv", code=2).err
    told("run", scene, "--out", tmp_path / "run", "--shard", "1/2")
    assert "unfinished" in told("info", tmp_path / "run", "--csv", code=2).err
    assert "--json" in told("info", tmp_path / "run", "--csv", "--json", code=2).out
