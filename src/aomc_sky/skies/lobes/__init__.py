"""Background skies: lobes that move and change with time, each with a spectrum in absolute units.

functions   The lobes by themselves in one place, public as `aomc_sky.lobes`
lobe        One lobe: density and sampler in its local frame with axis +z, and its rotation to the world
horizon     How much of a lobe stands above the horizon, plainly and weighted with the cosine
patches     Mass of a lobe in each patch of a grid, plainly and weighted with the cosine
envelope    What the sampler works with: the lobe turned to the horizon, and bins of equal probability with bounds
law         What the spine asks of a lobe: moments, rules of a plan, shares of patches, axis and width
sky         WeightedLobe and LobeSky: lobes with their light, and the components that the sampler gets
animation   One lobe over time: its keys, and what their times count from
background  BackgroundSky: animated lobes with their curves, and how they stand at one time
tables      What the emission reads of all lobes: shapes, envelopes and bins
light       Files of sky.toml become the light of a scene
file/       Background-sky files (DIRSIG BackgroundSkyData, HDF5)
kernels/    Photons of the lobes, and the queue of those that are tried again
"""
