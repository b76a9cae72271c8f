"""Directions of photons against the sky they come from.

directions        The tests of a source, prepared once for all its wavebands
direction_counts  Photons counted by zone, by position and by direction, block by block
zones             Zones of the sky, up to 16 in mu^2 and 16 in azimuth, and how the cells of a source spread over them
patches           Patches that photons come from, and the positions inside them: what is expected, counts, tests
zone_tests        Chi-square of zones, of mu^2 and of azimuth; scores of the commonest mistakes of a sampler
repeats           Photons that occur twice
"""
