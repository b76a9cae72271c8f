"""Atmosphere descriptions (.atmo), the format of CalcMySky.

builder  From the entries of a description file to the description: order, what is missing, species, the glow
code     Code blocks of a description file: raw lines between two fences, taken as they stand
data     An atmosphere as a description file has it: numbers in SI, spectra on its wavelengths, code as text
entries  Entries of one level of a description file, the file itself or a section, read to values
keys     Every key of a description file, and what it accepts
lines    The lines of a description file one by one, what they are put together to, and problems at their places
reader   Atmosphere descriptions (``.atmo``), the format of CalcMySky: all of it read and checked, no code evaluated
scan     The lines of a description file put together: entries and sections with their places; no values
spectra  Spectra of a description file: lists of numbers, tables in other files, and weighted sums of such tables
values   Values of a description file that stand in one line: from text to numbers, or a problem with its place
"""
