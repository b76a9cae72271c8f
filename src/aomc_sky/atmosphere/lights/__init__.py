"""What comes from outside: the sun's beam at the ground, and the Moon before the sun.

moon         The Moon before the sun, as seen from the observer
direct_beam  Light of the sun that reaches the ground unscattered: its irradiance, and the disc it comes from
"""
