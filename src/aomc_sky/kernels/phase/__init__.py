"""Phase functions and the scattering step: formulas, one text for arrays and for kernels.

rayleigh           The Rayleigh phase function
henyey_greenstein  The Henyey-Greenstein phase function
scatter            One scattering step
jitted             All of them for use inside an @njit function of a transport code, and their samplers over arrays
"""
