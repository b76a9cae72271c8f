"""Pictures of the sky dome: sources, runs, tables, pulls and background skies.

plot     `aomc_sky.plot`: anything that shines as a picture of the sky dome; tables, atmospheres and netCDF files too
backgrounds  Background skies: lobes at one time, or at several times side by side
picture  What a picture holds: domes, marks, a quantity; maps of pulls
source   Domes of the wavebands of a source, their marks, and lobes on patches that can be drawn
dome     How one dome is drawn: colours, letters and numbers, patches, rim, marks
panels   How several domes are drawn with their texts, colour bar and key
"""
