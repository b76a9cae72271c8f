"""The whole sky after its solution, and the ways to it.

method       What lights an atmosphere, which way it is solved, and which suns a way is good for
solve        An atmosphere solved for the whole sky at sea level, or in given directions
path_orders  Orders 2 and up of the whole sky by backward paths, and the light of a ground that glows
solved       A clear sky after its solution: smooth fields, radiance anywhere, means over patches
"""
