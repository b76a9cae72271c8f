"""Light scattered once, by quadrature on the spherical profile.

radiance     Radiance at the ground by quadrature over altitude, phase functions before the integrals
ray_panels   Where a ray from the ground is cut into panels, so that few Gauss nodes in each see smooth light
sun_columns  The sun table: particles per area between points of the atmosphere and the top
exact        Solved anew in every zenith angle: for suns below the horizon, whose shadow no series holds
eclipse      Under a sun that the Moon hides in part: quadrature along the way that is looked along
"""
