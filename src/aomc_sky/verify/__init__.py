"""Checks of a run, and of photons that anybody made: counts, bits, directions.

report      What a verification found: checks in order, maps of those that failed, and the laws behind p-values
counts      `aomc_sky.verify_counts`: photon counts against the masses they come from
sky/        Directions of photons against the sky they come from
made_again  A run folder, made again from its plan and compared
foreign     Photons that another code made: numpy files and MCPL, what they say of themselves, and their tests
"""
