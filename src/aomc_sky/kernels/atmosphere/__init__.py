"""Light in spherical shells: quadratures along rays, and paths followed backwards.

columns          Particles per area along straight rays: the quadrature under all optical depths
sunward          Columns from nodes of a ray towards the sun, looked up in the tables of their altitudes
order_one        Light scattered once on its way to the ground, by quadrature along straight rays
element_weights  Weights of a column's source function along straight lines, for successive orders of scattering
backward/        Paths of light followed backwards from the ground
"""
