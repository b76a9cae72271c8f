"""An atmosphere description becomes a medium, and its sky directions.

medium  A description becomes a medium: code blocks, cross sections; the Moon and the glow of the ground for a scene
solve   An atmosphere description is read and solved: in given directions, or as directions with weights
"""
