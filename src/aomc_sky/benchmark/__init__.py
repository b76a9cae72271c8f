"""Speed against error: what each sampler costs and what accuracy it buys.

accuracy      Errors of the samplers over replicates, and what they cost: the rows of the benchmark's table
bars          What speed and error must keep, as ratios measured in one run on the machine at hand
figure        Error against time, one line per method: small multiples, skies from top to bottom, quantities from ...
mcpl_peer     libmcpl through ctypes, the peer of our MCPL writer, and how many times longer it takes for the same ...
methods       The samplers of this package that are compared: names, and the options of `Scene.source` that they are
mitsuba_peer  Mitsuba 3 on Dr.Jit's LLVM backend as a photon source: `DiscreteDistribution` and jitter, float32, ...
page          The page on performance: one run and one check in Markdown, its plot and its numbers beside it
peers         Other people's samplers for the same job: photons of a table of patches, each uniform in its patch
quadrature    Quadratures over the hemisphere and over a cone, each at two orders; their difference is the stated ...
quantities    The five quantities whose error is measured, and their sums over emitted photons
run           A run of the benchmark: what is measured, the results, and how they are stored
skies         The skies of the benchmark: what shines, the same as a table for samplers that know patches alone, ...
speed         Photons per second of our methods, of their hosts and of the peers, turn and turn about, against ...
streamed      Peak memory of a process that streams photons: ``python -m bench.streamed N`` prints bytes
tables        The tables of a run: for a terminal, and the same as Markdown for the page on performance
threads       Two threads against one, and against two processes that share nothing: what the machine itself can give
timing        What every benchmark shares: contenders take turns, and medians and ratios are given with the machine
trends        What the rows say together: convergence slopes, and the time until an error is reached
truth         Exact values of the measured quantities, by sums over patches or by quadrature, each with its own error
"""
