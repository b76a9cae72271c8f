"""Light in spherical shells: quadratures along rays, and paths followed backwards.

backward/        Paths of light followed backwards from the ground.
columns          Particles per area along straight rays through a spherical atmosphere: the quadrature under all ...
element_weights  Weights of a column's source function along straight lines through its elements, for successive ...
order_one        Light scattered once on its way to the ground, by quadrature along straight rays
sunward          Columns from nodes of a ray towards the sun, looked up in the tables of their altitudes
"""
