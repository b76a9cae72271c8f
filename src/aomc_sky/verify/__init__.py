"""Checks of a run, and of photons that anybody made: counts, bits, directions.

counts      `aomc_sky.verify_counts`: photon counts against the masses they come from
made_again  A run folder, made again from its plan and compared; the plan made again from its scene
foreign     Photons that another code made: numpy files and MCPL, what they say of themselves, and their tests
directions  Directions of photons against the sky they come from: counts block by block, and the tests of a waveband
zones       Zones of the sky, up to 16 in mu^2 and 16 in azimuth, and how the cells of a source spread over them
zone_tests  Chi-square of zones, of mu^2 and of azimuth; shares of the commonest mistakes of a sampler
inside      Positions inside the patches that photons come from
repeats     Photons that occur twice
report      What a verification found: checks in order, maps of those that failed, and the laws behind p-values
"""
