"""Light of the sun and the Moon's eclipse in a spherical atmosphere over a Lambertian ground.

Each room may look at those above it, at no other.

numerics/           Numerics without physics
language/           The language of code blocks: a typed part of GLSL, checked once and evaluated over many altitudes
medium/             The air: constituents by altitude, their phase functions, optical depths along straight rays
lights/             What comes from outside: the sun's beam at the ground, and the Moon before the sun
order_one/          Light scattered once, by quadrature on the spherical profile
scattering_orders/  Light scattered more than once, by successive orders in columns
backward/           Light scattered more than once, by paths followed backwards
sky/                The whole sky after its solution, and the ways to it
"""
