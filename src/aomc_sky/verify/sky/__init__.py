"""Directions of photons against the sky they come from.

direction_counts  Photons counted by zone of the sky and inside patches, block by block, in bounded memory
directions        Directions of photons against the sky they come from: of our own runs and of any other code's
edge_finder       Intervals and patches that many numbers lie in, found by tables of equal steps and not by bisection
fixed_directions  Places of a sky where photons come from single directions or from a small disc: edges of zones ...
grid_cuts         Rings and columns of patches, cut where zones begin
interior_tests    Tests of places inside patches, all patches together
patch_interior    Where photons lie inside the patches of a sky: both coordinates counted in equal steps, over all ...
photon_angles     Where the photons of a chunk come from: angles and squares of their directions, a column each
repeats           Photons that repeat another one: pairs of equal directions, against pairs that are only neighbours
share_scores      How many photons come from a sampler's commonest mistakes, by tests of one degree of freedom each
zone_shares       How the cells of a source spread over zones of the sky: exact masses of the models, no sampling
zone_tests        Tests of photons counted by zone: one statistic for each way in which photons may be tied together
zones             Zones of the sky in which photons are counted: up to 16 in mu^2 and 16 in azimuth, on edges of ...
"""
