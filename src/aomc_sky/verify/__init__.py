"""Checks of a run, and of photons of any program: counts, bits, directions.

counts      `aomc_sky.verify_counts`: photon counts against the masses they come from
reproduce   Makes a run folder again from its plan, or the plan from its scene, and compares
foreign     Photons that another code made: their files, the origin that a file states, and tests against a scene
directions  Directions of photons against the sky they come from: counts block by block, and the tests of a waveband
zones       Zones of the sky, up to 16 in mu^2 and 16 in azimuth, and how the cells of a source spread over them
zone_tests  Chi-square of zones, of mu^2 and of azimuth; shares of the commonest mistakes of a sampler
inside      Positions inside the patches that photons come from
repeats     Photons that occur twice
report      The report of a verification: checks, maps of pulls, and the distributions behind p-values
"""
