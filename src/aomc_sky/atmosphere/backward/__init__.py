"""Light scattered more than once, by paths followed backwards.

monte_carlo  Radiance of the sky by backward paths: by order, with its error, and where that is not to be trusted
tables       What backward paths read of a medium: uniform shells, optical depths to the top, phase functions
orders       Orders 2 and up of the whole sky, and the light of a ground that glows
"""
