"""Pictures of the sky dome: sources, runs, tables, pulls and animations.

domes/    What a picture shows: domes, and where their values come from.
drawing/  How a picture is drawn.
animate   `aomc_sky.animate`: a background sky over time, as a GIF
plot      `aomc_sky.plot`: anything that shines as a picture of the sky dome
pull      Maps of pulls: where photons lie off what is expected
tables    Tables as domes: a skydist.inp, and the netCDF files that the package writes
"""
