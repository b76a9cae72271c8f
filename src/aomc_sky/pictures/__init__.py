"""Pictures of the sky dome: sources, runs, tables, pulls and animations.

plot      `aomc_sky.plot`: anything that shines as a picture of the sky dome
animate   `aomc_sky.animate`: a background sky over time, as a GIF
content   What a picture holds: domes, marks, a quantity
domes/    Where the values of a picture come from
tables    Results as domes: a skydist.inp, an atmosphere, and the netCDF files that the package writes
pull      Maps of pulls: where photons lie off what is expected
drawing/  How a picture is drawn
"""
