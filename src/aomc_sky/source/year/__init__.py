"""A year of skies as scenes to come.

plan    The hours of a weather file as scenes to come: what every hour needs, settled before the first one
schema  What the plan of a year of skies may be
"""
