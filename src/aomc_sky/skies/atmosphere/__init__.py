"""Light of the sun and the Moon's eclipse in a spherical atmosphere over a Lambertian ground.

Each file or room may look at those above it, at no other.

language/           The language of code blocks: a typed part of GLSL, checked once and evaluated over many altitudes
medium              The air: constituents by altitude, densities and phase functions from code blocks
phase_table         Phase functions as tables: their norm, and their values between the angles
optical_depth       Densities as polynomials between edges, and optical depths along straight rays through them
lights              What comes from outside: the Moon before the sun, and the sun's beam at the ground
order_one           Light scattered once, by quadrature on the spherical profile
eclipse             Light scattered once under a sun that the Moon hides in part
scattering_orders/  Light scattered more than once, by successive orders in columns
backward            Light scattered more than once, by paths followed backwards
sky/                The whole sky after its solution, and the ways to it
description/        Atmosphere descriptions (.atmo): their reader, and the medium that they describe
model               The sky model: radiance of the solution in absolute units, and its direct beam
kernels/            Light in spherical shells: quadratures along rays, and paths followed backwards
"""
