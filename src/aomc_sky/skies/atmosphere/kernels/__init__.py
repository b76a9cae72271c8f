"""Light in spherical shells: quadratures along rays, and paths followed backwards.

rays           Where a straight ray is: formulas for numpy and for the kernels alike
ray_integrals  Integrals along straight rays: particles per area, and weights of a column's source function
order_one      Light scattered once on its way to the ground, by quadrature along straight rays
paths          Paths of light followed backwards from the ground: state, random numbers, flights, vertices, sums
shells         Uniform shells as such paths meet them: optical depths, phase functions, ways, the visible sun
"""
