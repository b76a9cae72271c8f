"""Background skies: lobes that move and change with time, each with a spectrum in absolute units.

functions   The lobes by themselves, public as `aomc_sky.lobes`
lobe        One lobe: density and sampler in its local frame with axis +z, and its rotation to the world
horizon     The part of a lobe above the horizon, plainly and weighted with the cosine
patches     Mass of a lobe in each patch of a grid, plainly and weighted with the cosine
envelope    The envelope for the sampler: the lobe turned to the horizon, and bins of equal probability with bounds
law         The laws of lobes as the spine asks for them: moments, rules of a plan, shares, axis, tables of the emission
sky         WeightedLobe and LobeSky: lobes with their light, and the components that the sampler gets
background  BackgroundSky: animated lobes with their curves, and the lobes at one time
light       Files of sky.toml become the light of a scene
file/       Background-sky files (DIRSIG BackgroundSkyData, HDF5)
kernels/    Photons of the lobes, and the queue of those that are tried again
"""
