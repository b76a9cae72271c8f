"""Numerics without physics.

adaptive_integral  Integrals of several functions at once, by panels that are halved where they need it
kinks              Places where a function that is made of pieces goes over from one piece to the next
legendre           Phase functions as series of Legendre functions: one Fourier mode at a time; nodes of a hemisphere
sky_field          Smooth functions of the sky direction, kept as Chebyshev and cosine series
"""
