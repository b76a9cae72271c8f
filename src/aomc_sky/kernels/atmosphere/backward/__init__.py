"""Paths of light followed backwards from the ground.

paths    What a path is; many of them in one direction, followed abreast, and their sums
each     One path for each of many directions, addressed by its number: any part of them is followed by itself
state    Rows of the paths' state, and where the light of a path goes
numbers  Random numbers of a step, one block of Philox for each path
flight   Flights: to the first collision, which is forced, and to the next vertex
march    The way of a ray through uniform spherical shells until it has passed a given optical depth
vertex   Vertices: the sun's light that they turn into a path, and its new direction
light    What a vertex sees: optical depth to the top, phase functions, the part of the sun not eclipsed
"""
