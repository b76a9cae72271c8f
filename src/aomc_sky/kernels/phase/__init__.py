"""Phase functions and the scattering step.

fill                      The samplers of the phase functions over arrays
henyey_greenstein         The Henyey-Greenstein phase function's formulas: + - x / sqrt alone, for arrays, and for ...
jitted_henyey_greenstein  The Henyey-Greenstein phase function for use inside an @njit function of a transport code
jitted_rayleigh           The Rayleigh phase function for use inside an @njit function of a transport code
jitted_scatter            One scattering step for use inside an @njit function of a transport code
rayleigh                  The Rayleigh phase function's formulas: + - x / alone, for arrays, and for ...
scatter                   One scattering step: the formulas, + - x / sqrt and rounding alone, for arrays and for ...
"""
