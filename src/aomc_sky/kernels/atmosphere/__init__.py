"""Light in spherical shells: quadratures along rays, and paths followed backwards.

columns          Particles per area along straight rays: the quadrature under all optical depths
order_one        Light scattered once on its way to the ground, by quadrature along straight rays
element_weights  Weights of a column's source function along straight lines, for successive orders of scattering
paths            Paths of light followed backwards from the ground: many in one direction, or one for each direction
path_steps       Steps of such a path: its state, its random numbers, its flights and its vertices
shells           Uniform shells as such paths meet them: optical depths, phase functions, ways, the visible sun
"""
