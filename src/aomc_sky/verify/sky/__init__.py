"""Directions of photons against the sky they come from.

directions        The tests of a source, prepared once for all its wavebands
zones             Zones of the sky in which photons are counted: up to 16 in mu^2 and 16 in azimuth, on edges of patches
grid_cuts         Rings and columns of patches, cut where zones begin
fixed_directions  Where photons come from single directions or from a small disc: edges of zones keep clear of them
zone_shares       How the cells of a source spread over zones
photon_angles     Sky directions of photons, a column each
edge_finder       The patch and the zone of millions of directions
direction_counts  Photons counted by zone, by position and by direction, block by block
zone_tests        Chi-square of zones, of mu^2 and of azimuth
share_scores      Tests of zones where photons are spread evenly
interior          Positions inside patches: what is expected, counts, tests
repeats           Photons that occur twice
"""
