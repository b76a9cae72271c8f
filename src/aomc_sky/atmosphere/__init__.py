"""Light of the sun and the Moon's eclipse in a spherical atmosphere over a Lambertian ground.

backward/           Light scattered more than once, by paths followed backwards.
language/           The language of code blocks: a typed part of GLSL, checked once and evaluated over many ...
medium/             The air: constituents by altitude, their phase functions, optical depths along straight rays.
numerics/           Numerics without physics.
order_one/          Light scattered once, by quadrature on the spherical profile.
scattering_orders/  Light scattered more than once, by successive orders in columns.
sky/                The whole sky after its solution, and the ways to it.
"""
