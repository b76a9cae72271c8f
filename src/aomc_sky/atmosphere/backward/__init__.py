"""Light scattered more than once, by paths followed backwards.

monte_carlo  Radiance of the sky by paths of light followed backwards through spherical shells, for any sun
result       What backward paths bring: radiances by order, their errors, and where these are not to be trusted
tables       What backward paths read of a medium: uniform shells, optical depths to the top, phase functions
orders       Orders 2 and up of the whole sky, and the light of a ground that glows
"""
