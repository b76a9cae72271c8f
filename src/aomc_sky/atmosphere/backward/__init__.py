"""Light scattered more than once, by paths followed backwards.

ground_glow  Light of a ground that glows by itself, such as that of towns, scattered back to the observer: by ...
monte_carlo  Radiance of the sky by paths of light followed backwards through spherical shells, for any sun
orders       Orders 2 and up of the whole sky by backward paths, as series of the azimuth
result       What backward paths bring: radiances by order, their errors, and where these are not to be trusted
tables       What backward paths read of a medium: uniform shells, optical depths to the top, phase functions over t
"""
