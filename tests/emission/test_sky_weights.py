"""One run under every sky: weights by radiance over launch give the tallies of a run of its own."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.directions import sky_angles

N = 100_000
pytestmark = pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")


def diffuse(**light):
    return sky.weather_scene(wavebands=[550.0], n_photons=N, diffuse_only=True, **light)


RUN = {"sun_zenith_deg": 50.0, "dni": 500.0, "dhi": 200.0}
OTHERS = {
    "perez": {"sun_zenith_deg": 30.0, "sun_azimuth_deg": 70.0, "dni": 850.0, "dhi": 90.0},
    "overcast": {"sky": "overcast"},
    "harrison-coombes": {"sky": "harrison-coombes", "sun_zenith_deg": 60.0, "sun_azimuth_deg": 200.0},
}
TALLIES = {
    "all": lambda zenith, azimuth: np.ones_like(zenith),
    "cosine": lambda zenith, azimuth: np.cos(zenith),
    "side": lambda zenith, azimuth: np.cos(azimuth) * np.sin(zenith),
    "overhead": lambda zenith, azimuth: (zenith < 0.3) * 1.0,
}
HOW = {
    "plain": {},
    "importance": {"importance": {"perez": lambda zenith, azimuth: 1.0 + 5.0 * np.sin(zenith) + 0.0 * azimuth}},
    "patch order": {"order": "patch"},
    "float32": {"precision": "float32"},
}


def angles_of(batch):
    return sky_angles(np.column_stack([batch.ux, batch.uy, batch.uz]).astype(np.float64))


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("other", OTHERS)
def test_tallies_are_those_of_a_run_of_its_own(other, how):
    source = diffuse(**RUN).source(1, **{"precision": "float64"} | HOW[how])
    scene = diffuse(**OTHERS[other])
    batch, own = source.photons(), scene.source(2, precision="float64").photons()
    weight = source.weights_for(scene, batch)
    assert weight.dtype == np.float64
    for tally in TALLIES.values():
        expected = float(np.mean(tally(*angles_of(own))))
        assert float(np.mean(weight * tally(*angles_of(batch)))) == pytest.approx(expected, abs=4e-4)


def test_photons_of_a_beam_have_no_part_and_the_rest_is_the_whole_diffuse_light():
    with_beam = sky.weather_scene(wavebands=[550.0], n_photons=N, **RUN)
    scene = diffuse(**OTHERS["perez"])
    for bias in ({}, {"direct": 0.2}):
        source = with_beam.source(1, bias=bias)
        batch = source.photons()
        weight = source.weights_for(scene, batch)
        assert np.all(weight[source.component_of(batch.patch) == 0] == 0)
        assert weight.mean() == pytest.approx(1.0, abs=1e-3)
        planted = weight * (1.0 if batch.weight is None else batch.weight)  # the weights of the bias once more
        assert not bias or abs(planted.mean() - 1.0) > 0.05


def test_several_diffuse_components_share_one_density():
    grid = sky.PatchGrid.regular(9, 36)
    parts = [
        sky.PerezSky(sun_zenith_deg=50.0, epsilon=4.0, delta=0.2, strength=0.6),
        sky.TabulatedSky(grid=grid, wavelength_nm=[550.0], values=np.ones((1, 9, 36)), strength=0.4),
    ]
    source = sky.Scene(wavebands=[550.0], n_photons=N, components=parts).source(1, bias={"perez": 0.3})
    weight = source.weights_for(diffuse(**OTHERS["overcast"]), batch := source.photons())
    zenith, _ = angles_of(batch)
    assert weight.mean() == pytest.approx(1.0, abs=1e-3)
    assert float(np.mean(weight * np.cos(zenith))) == pytest.approx(
        float(5 / 7), abs=1e-3
    )  # (1 + 2 mu) / 3 of overcast


def test_absolute_weights_have_the_irradiance_as_their_mean():
    pytest.importorskip("pvlib")
    source, scene = diffuse(**RUN).source(1), diffuse(**OTHERS["perez"], spectrum="spectrl2")
    batch = source.photons()
    total = float(scene.irradiance.of_component[0].sum())
    assert source.weights_for(scene, batch, absolute=True).mean() == pytest.approx(total, rel=1e-4)
    assert source.weights_for(scene, batch).mean() == pytest.approx(1.0, rel=1e-4)


def test_what_is_refused():
    source = diffuse(**RUN).source(1)
    batch = source.photons(stop=100)
    with pytest.raises(sky.UsageError, match=r"'direct' is a beam: taken as a patch it is wrong .* a table of suns"):
        source.weights_for(sky.weather_scene(wavebands=[550.0], n_photons=N, **RUN), batch)
    with pytest.raises(sky.UsageError, match="irradiance is known; leave absolute out"):
        source.weights_for(diffuse(**OTHERS["overcast"]), batch, absolute=True)
    with pytest.raises(sky.UsageError, match="expected a Scene, got int"):
        source.weights_for(5, batch)
    grid, half = sky.PatchGrid.regular(9, 36), np.ones((1, 9, 36))
    by_angle = sky.TabulatedSky(grid=grid, wavelength_nm=[550.0], values=half, weighting=sky.Weighting.SOLID_ANGLE)
    run = sky.Scene(wavebands=[550.0], n_photons=N, components=by_angle).source(1)
    with pytest.raises(sky.UsageError, match="launched by solid angle"):
        run.weights_for(diffuse(**OTHERS["overcast"]), run.photons(stop=100))
    half[:, :, 18:] = 0.0
    table = sky.TabulatedSky(grid=grid, wavelength_nm=[550.0], values=half)
    one_side = sky.Scene(wavebands=[550.0], n_photons=N, components=table).source(1)
    with pytest.raises(
        sky.UsageError, match=r"0.5 of the light of this sky comes from directions where the run has no"
    ):
        one_side.weights_for(diffuse(**OTHERS["overcast"]), one_side.photons(stop=100))
    few = sky.Scene(wavebands=[550.0], n_photons=500, components="uniform").source(1)
    with pytest.raises(sky.UsageError, match=r"count as 500; at least 1000 are needed; take more"):
        few.weights_for(diffuse(**OTHERS["overcast"]), few.photons())


def test_photons_that_float32_rounds_over_an_edge_have_weights():
    """A patch with light beside a dark one: the direction in float32 lies in the dark one for a few in a million."""
    values = np.ones((1, 90, 360))
    values[0, ::2, ::2] = 0.0
    table = sky.TabulatedSky(grid=sky.PatchGrid.regular(90, 360), wavelength_nm=[550.0], values=values)
    scene = sky.Scene(wavebands=[550.0], n_photons=400_000, components=table)
    source = scene.source(1)
    weight = source.weights_for(scene, source.photons())
    np.testing.assert_allclose(weight, 1.0, rtol=1e-9)


def test_a_needle_that_no_patch_sees_is_refused():
    run = sky.Scene(wavebands=[550.0], n_photons=N, components="uniform").source(1)
    spectrum = {"wavelength_nm": np.array([400.0, 700.0]), "spectrum": np.ones(2)}
    turned = np.array([1.0, 0.0, 0.29, 0.0])
    lobe = sky.lobes.WeightedLobe(name="g", kind="ggx", param0=1e-3, param1=1e-3, quaternion=turned, **spectrum)
    scene = sky.Scene(wavebands=[550.0], n_photons=N, components=sky.LobeSky(lobes=(lobe,)))
    with pytest.raises(sky.UsageError, match=r"count as \d+; at least 1000 are needed"):
        run.weights_for(scene, run.photons())


def test_photons_in_the_middle_of_patches_are_refused():
    source = diffuse(**RUN).source(1, placement="centre")
    with pytest.raises(sky.UsageError, match="in the middle of patches; make it with placement r2 or philox"):
        source.weights_for(diffuse(**OTHERS["overcast"]), source.photons())


@pytest.mark.parametrize("batch", [None, "x", np.zeros(3)])
def test_a_batch_is_a_batch(batch):
    with pytest.raises(sky.UsageError, match="expected a PhotonBatch"):
        diffuse(**RUN).source(1).weights_for(diffuse(**OTHERS["overcast"]), batch)
