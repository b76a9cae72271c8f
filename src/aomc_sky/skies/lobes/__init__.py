"""Background skies: lobes that move and change with time, each with a spectrum in absolute units.

functions   The lobes by themselves in one place, public as `aomc_sky.lobes`
laws        Densities and samplers of the three lobes in the local frame with axis +z
quaternion  Rotations between the local frame of a lobe and the world
error_free  Sums of products and quotients as if in twice the precision
horizon     How much of a lobe stands above the horizon, plainly and weighted with the cosine
contour     Mass of a lobe in cells of zenith angle and azimuth, from integrals along their edges
patches     Mass of a lobe in each patch of a grid, plainly and weighted with the cosine
frame       One lobe turned to the horizon: the coordinates of its sampler
envelope    Bins of equal probability in these coordinates, each with a bound of the cosine
sky         WeightedLobe and LobeSky: lobes with their light, and the components that the sampler gets
animation   One lobe over time: its keys, and what their times count from
background  BackgroundSky: animated lobes with their curves, and how they stand at one time
"""
