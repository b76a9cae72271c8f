"""Numerics without physics.

adaptive_integral  Integrals of several functions at once, by panels that are halved where they need it
angular_nodes      Directions of the orders of scattering: Gauss nodes of a hemisphere and the Legendre functions ...
kinks              Places where a function that is made of pieces goes over from one piece to the next
legendre           Phase functions as series of Legendre functions: the azimuth of a scattering problem, one ...
"""
