"""Phase functions and the scattering step: formulas for arrays, which `jitted` compiles as they stand.

rayleigh           The Rayleigh phase function
henyey_greenstein  The Henyey-Greenstein phase function
scatter            One scattering step
jitted             All of them for use inside an @njit function of a transport code, and their samplers over arrays
"""
