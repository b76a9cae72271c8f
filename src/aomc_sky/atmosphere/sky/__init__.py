"""The whole sky after its solution, and the ways to it.

method               What lights an atmosphere, which way it is solved, and which suns a way is good for
solve_sky            An atmosphere solved for the whole sky at sea level
solved               A clear sky after its solution: radiance anywhere on it, order by order, and the direct beam
solve                Radiance in given directions, each solved for itself
means                Means of a solved sky over patches: what the flux law of a patch wants, to a known error
weighted_directions  Light of a sky as directions with weights: no table, no bins, one backward path for each
"""
