"""An atmosphere description becomes a medium, and its sky directions.

medium               A description becomes a medium: code blocks evaluated and checked, cross sections by wavelength
night_lights         The Moon before the sun and the glow of the ground, as a scene asks for them of a description
solve                An atmosphere description is read and solved in given directions
weighted_directions  An atmosphere description is read, and its sky given as directions with weights
"""
