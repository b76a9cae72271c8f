"""The whole sky after its solution, and the ways to it.

directed_paths       Radiance of a solved sky in given directions by backward paths: as many in each as the number ...
direction_density    A density that directions of the sky are drawn from: light scattered once in patches, and a floor
lights               What lights an atmosphere: the sun, whole or behind the Moon, and a ground that glows
means                Means of a solved sky over patches: what the flux law of a patch wants, to a known error
method               Which way an atmosphere is solved, and which suns a way is good for
once_field           Light scattered once over the whole sky, as a field: how it is fitted, and how well
solve                Radiance of a clear sky at sea level in given directions: order 1 through shells, and ...
solve_sky            Solve an atmosphere for the whole sky at sea level
solved               A clear sky after its solution: radiance anywhere on it, order by order, and the direct beam
weighted_directions  Light of a clear sky as directions with weights: no table, no bins, one backward path for each ...
"""
