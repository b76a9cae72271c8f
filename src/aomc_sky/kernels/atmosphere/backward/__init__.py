"""Paths of light followed backwards from the ground.

each     One backward path for each of many directions, addressed by its number: any part of them is followed by ...
flight   Flights of paths that are followed backwards: to the first collision, which is forced, and to the next vertex
light    What a vertex of a backward path sees: optical depth to the top, phase functions, the part of the sun not ...
march    The way of a ray through uniform spherical shells until it has passed a given optical depth
numbers  Random numbers of a step of paths that are followed backwards, one block of Philox for each path
paths    Paths of light followed backwards from the ground through spherical shells
state    The state of paths that are followed backwards: what its rows are, and where the light of a path goes
vertex   Vertices of paths that are followed backwards: the sun's light that they turn into a path, its new direction
"""
