"""Any photon of a plan by its index.

photon_source  The photon source: random access to every photon of a plan, without state
photons        A batch of photons: a struct of arrays, and how a caller's arrays are reused
emitter        From a plan to arrays of photons: which kernel makes them, and the tables it reads
band           A band as the kernels read it: cells as words, the words of random streams, and how they are packed
irradiance     Irradiance of a scene: in absolute units of each component, and planar over scalar of a band's photons
radiance       Radiance of the diffuse light as the photons have it: of patches, and in any direction of the sky
sky_weights    The photons of one run under another sky: a weight for each, because light is linear
notebook       A table and the dome of the sky in a notebook
host           A band's photons inside another code's own loop: jitted functions for numba
source_file    A source as one block of bytes, which aomc_sky.h reads
source_witnesses  Photons that every compiler of aomc_sky.h must give
kernels/       Photons of a band: the compiled text, its plain twin, hosts and batches
"""
