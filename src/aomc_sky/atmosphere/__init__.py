"""Light of the sun in a spherical atmosphere over a Lambertian ground: optical depths, orders of scattering, tables."""
