"""An atmosphere description becomes a medium, and its sky directions.

kept_sky  The sky of an atmosphere from the cache where it was solved before
medium    A description becomes a medium: code blocks, cross sections; the Moon and the glow of the ground for a scene
solve     An atmosphere description is read and solved: in given directions, or as directions with weights
"""
