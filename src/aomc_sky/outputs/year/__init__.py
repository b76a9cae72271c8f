"""The folder of a year of skies.

folder    The folder of a year of skies: counts and index grow in step, one block of hours after the other
index     index.csv of a year: one line per row of the weather file, those without a sky among them
manifest  manifest.json of a year of skies, written last. Everything about time and machine stands under ``run``
"""
