"""What a picture shows: domes, and where their values come from.

atmosphere   The clear sky of an atmosphere as domes, one for each wavelength
background   Background skies as domes: at one time, or at many, one after the other
content      What a picture shows: domes of patches with their values, marks on them, and what the colours mean
lobe_share   Lobes in pictures: their shares of patches, where they are, how wide, and what is said of them
marks        Where the marks of a dome stand: beams, the sun, narrow lobes
narrow_lobe  Shares of patches of a lobe that is narrower than they are, fast enough for a picture
patches      Patches that can be drawn: points as areas, and one grid for components that have different ones
source       A photon source as domes: radiance, or photons per steradian, of every waveband
"""
