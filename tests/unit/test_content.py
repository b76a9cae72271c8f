"""Records with arrays compare by content and never raise; their reprs are one line."""

import copy
import dataclasses

import numpy as np
import pytest

import aomc_sky as sky

NOON = {"wavebands": [443.0, 555.0], "n_photons": 1000, "sun_zenith_deg": 40.0, "ghi": 780.0, "dhi": 140.0}


def records():
    scene = sky.weather_scene(**NOON)
    source, grid = scene.source(seed=1), sky.PatchGrid.regular(4, 8)
    table = sky.SkyTable(wavelength_nm=np.array([500.0]), radiance=np.ones((1, 3, 5)))
    return [scene, source.plan, source.photons(0), scene.components[1], scene.wavebands, grid, table]


def changed(record):
    """The record with one number changed."""
    if isinstance(record, sky.Plan):
        return dataclasses.replace(record, arrays={**record.arrays, "mass": record.arrays["mass"] * 2})
    other = copy.copy(record)
    name = next(f.name for f in dataclasses.fields(record) if isinstance(getattr(record, f.name), np.ndarray))
    array = np.array(getattr(record, name))
    array.flat[0] += 1
    object.__setattr__(other, name, array)
    return other


@pytest.mark.parametrize("k", range(7))
def test_equal_records_are_equal_and_others_are_not(k):
    one, other = records()[k], records()[k]
    assert one == other
    assert one != changed(other)
    assert one != "another thing"
    assert one != records()[k - 1]


def test_nan_is_equal_to_nan():
    scene = sky.weather_scene(**NOON)
    assert np.isnan(scene.sky_wavelength_nm).all()
    assert scene == sky.weather_scene(**NOON)


@pytest.mark.parametrize("k", range(7))
def test_a_repr_is_short(k):
    assert len(repr(records()[k])) < 120


def test_reprs_say_what_is_there():
    scene, plan, batch, component, *_ = records()
    assert repr(scene) == "<Scene: 2000 photons, 2 wavebands 443 to 555 nm; direct, perez>"
    assert repr(plan).startswith(f"<Plan {plan.sha256[:16]}: 2000 photons in 2 wavebands, 8101 cells, seed 1")
    assert repr(batch) == "<PhotonBatch: photons 0 to 999 of band 0 at 443 nm, float32>"
    assert repr(component) == "<Component 'perez': PEREZ, 8100 cells>"


def test_slices_and_arrays_of_a_batch():
    source = sky.weather_scene(**NOON).source(seed=1)
    batch = source.photons(0)
    part = batch[100:250]
    assert part == source.photons(0, 100, 250)
    assert batch[:-10].start == 0
    assert len(batch[:-10]) == 990
    assert np.shares_memory(part.ux, batch.ux)
    assert list(batch.to_dict()) == ["ux", "uy", "uz", "patch"]
    with pytest.raises(TypeError, match="slices"):
        batch[3]
    with pytest.raises(ValueError, match="follow each other"):
        batch[::2]
