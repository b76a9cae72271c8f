"""Background skies: lobes that move and change with time.

animation      One lobe that moves and changes with time: its keys, and the rules of time of background-sky files
background     A background sky: lobes that move and change with time, each with a spectrum in absolute units
background_at  Background skies at one time: the animated lobes stop, and the light of several skies adds
components     Lobes of a background sky at a fixed time as components of a scene, one each
contour        Mass of a lobe in cells of zenith angle and azimuth, from integrals along the edges of the cells
envelope       The envelope of a lobe's sampler: bins of equal probability over the lobe's own coordinates, each ...
error_free     Sums of products and quotients as if in twice the precision, for differences and powers that must ...
frame          One lobe before the horizon in the frame of its sampler: shares of the lobe and an azimuth become a ...
functions      The lobes of background skies by themselves: density, sampler, masses above the horizon and over ...
horizon        How much of a lobe stands above the horizon, plainly and weighted with the cosine of the zenith angle
laws           Densities and samplers of the three lobes of DIRSIG's background skies, in the local frame with axis +z
patches        Mass of a lobe in each patch of a grid, plainly and weighted with the cosine of the zenith angle
quadrature     Projected mass of a lobe in cells of zenith angle and azimuth, from Gauss points inside the cells
quaternion     Rotations between the local frame of a lobe and the world, from quaternions of any length
share          How the light of a lobe spreads over patches, from the component alone
sky            A background sky at one time: a sum of lobes, each with a spectrum, in absolute units
"""
