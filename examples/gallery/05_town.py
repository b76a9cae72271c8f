"""
A town on the horizon
=====================

Light of the night as lobes: a narrow glow of a town in the east, a wide one of a city in the north-west, airglow over
both.
"""

import tempfile

import aomc_sky as sky

lobes = {
    "town": sky.lobes.SkyLobe(kind="hg", width=0.9, zenith_deg=86, azimuth_deg=10, spectrum=[1e-9, 4e-9]),
    "city": sky.lobes.SkyLobe(kind="hg", width=0.7, zenith_deg=88, azimuth_deg=130, spectrum=[4e-9, 2e-8]),
    "airglow": sky.lobes.SkyLobe(kind="hg", width=0.0, spectrum=[2e-9, 5e-9]),
}
with tempfile.TemporaryDirectory() as folder:
    file = f"{folder}/town.h5"
    sky.lobes.write_background(file, sky.lobes.background_of_lobes(lobes, [440, 550]))
    night = sky.background_at(sky.read_background(file), unix_time_s=0)

scene = sky.Scene(wavebands=[440, 550], n_photons=1_000_000, components=night)
figure = sky.plot(scene, caption=False)
