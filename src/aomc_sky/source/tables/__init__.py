"""Tables that the emission kernels read, made from a plan.

band          The tables of one band in the form the emission kernel reads: its cells with photons, and a guide
emitter       From a plan to arrays of photons: which kernel makes them, and the tables it reads
lobes         The lobes of a plan in the form the emission reads
rings         The rings of a plan's cells, and the turn that each adds to the azimuthal places of its photons
stream_words  The words of the random streams that one band needs before its first photon
"""
