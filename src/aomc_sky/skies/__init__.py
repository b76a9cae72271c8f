"""Sky models: radiance as a function of direction and wavelength. One file each, or a folder.

model            The promises of every sky model, and the share of a model in the light of a scene
uniform          A sky of equal radiance everywhere
overcast         The overcast sky of the CIE, cardioidal in ocean optics
cie              The fifteen general skies of the CIE
harrison_coombes The clear sky of Harrison and Coombes
function_sky     A sky given by a function of direction and wavelength
patch_integrals  Integrals of a radiance over patches: masses, slopes, and the error of a linear law
quadrature       Integrals over patches by one adaptive Gauss rule in plain numpy
tabulated        A table of values, also with the AOMC 1.2.2 program's own weights in 32-bit arithmetic
measured         Radiances in scattered directions, as instruments give them
on_sphere        Their interpolation on the sphere, with its errors
radiance_field   A radiance field with coordinates becomes means and slopes of patches
field            The file of such a field: what is read, said, and seen in its light
field_choice     Which variable is the radiance, and what stands beside it
field_axes       Its coordinates in our conventions, and gaps
polarised_field  A field of Stokes parameters
polarisation     Rayleigh's pattern on the light of a sky
witnesses        What the light itself says of a table or a field
jumps            Meridians and parallels along which a radiance jumps
direct_beam      The direct beam of the sun: a direction, or the solar disc
perez/           The all-weather sky of Perez, Seals and Michalsky (1993)
lobes/           Background skies: their files, lobes that move and change with time, each with a spectrum
atmosphere/      The clear sky of a physical atmosphere: its file, its solution, and the model in absolute units
"""
