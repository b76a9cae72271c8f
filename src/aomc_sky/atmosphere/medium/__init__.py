"""The air: constituents by altitude, their phase functions, optical depths along straight rays.

constituents    An atmosphere as its solvers see it: constituents by altitude, cross sections and phase functions
molecules       Scattering cross section of a gas from its refractive index: what ``cross section at 1 um`` wants
number_density  A number density from a code block: checked over all altitudes, with its jumps and bends
phase_block     A phase function from a code block: checked, and divided by its integral over the sphere
profile         The densities as polynomials between edges: what every quadrature reads instead of user code
optical_depth   Optical depth along straight rays: to the top, to the ground, of the sun's beam
"""
