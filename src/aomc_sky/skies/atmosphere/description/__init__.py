"""Atmosphere descriptions (.atmo), the format of CalcMySky.

reader   `read_atmo`: from the lines of a file to its description; values, order, what is missing, species, the glow.
data     The description: numbers in SI, spectra on its wavelengths, code as text.
keys     Every key of a file, and what it accepts.
scan     The lines put together: entries, sections and code blocks with their spans; no values.
medium   Blocks of code become the constituents of a medium, and lights; spectra between the wavelengths of a file.
spectra  Lists of numbers, tables in other files and their sums; phase functions as tables; luminance of a spectrum.
"""
